"""UTM against published coordinates and, for random places, Snyder's series, which is in the manuals of surveyors."""

from __future__ import annotations

from math import atan2, cos, inf, isnan, nan, radians, sin, sqrt, tan

import numpy as np
import pytest

from pyros1.robot_nodes.robot_localization.utm import Grid, UtmError


def snyder(latitude: float, from_meridian: float) -> tuple[float, float]:
    """Return easting and northing; J. P. Snyder, "Map Projections: A Working Manual" (1987), equations 8-9 and 8-10."""
    e2 = (2 - 1 / 298.257223563) / 298.257223563
    phi, ep2 = radians(latitude), e2 / (1 - e2)
    n, t, c = 6378137.0 / sqrt(1 - e2 * sin(phi) ** 2), tan(phi) ** 2, ep2 * cos(phi) ** 2
    a = cos(phi) * radians(from_meridian)
    m = 6378137.0 * (
        (1 - e2 / 4 - 3 * e2**2 / 64 - 5 * e2**3 / 256) * phi
        - (3 * e2 / 8 + 3 * e2**2 / 32 + 45 * e2**3 / 1024) * sin(2 * phi)
        + (15 * e2**2 / 256 + 45 * e2**3 / 1024) * sin(4 * phi)
        - 35 * e2**3 / 3072 * sin(6 * phi)
    )
    x = n * (a + (1 - t + c) * a**3 / 6 + (5 - 18 * t + t * t + 72 * c - 58 * ep2) * a**5 / 120)
    y = m + n * tan(phi) * (
        a * a / 2 + (5 - t + 9 * c + 4 * c * c) * a**4 / 24 + (61 - 58 * t + t * t + 600 * c - 330 * ep2) * a**6 / 720
    )
    return 500_000 + 0.9996 * x, 0.9996 * y


@pytest.mark.parametrize(
    ("latitude", "longitude", "zone", "easting", "northing"),
    [
        (51.423964, 5.494271, 31, 673409.989, 5699924.709),
        (-43.530955, 172.636645, 59, 632246.802, 5178919.718),
        (43.642567, -79.387139, 17, 630084, 4833438),  # the CN Tower, as in Wikipedia's article on UTM
        (0.0, 3.0, 31, 500000.0, 0.0),
    ],
)
def test_published_coordinates(latitude: float, longitude: float, zone: int, easting: float, northing: float) -> None:
    grid = Grid.at(latitude, longitude)
    assert grid == Grid(zone, latitude >= 0.0)
    assert grid.forward(latitude, longitude) == pytest.approx((easting, northing), abs=1.0 if zone == 17 else 0.001)


def test_random_places() -> None:
    random = np.random.default_rng(0)
    for latitude, away in zip(random.uniform(-80, 84, 200).tolist(), random.uniform(-3, 3, 200).tolist(), strict=True):
        grid = Grid(random.integers(1, 61).item(), latitude >= 0.0)
        longitude = 6.0 * grid.zone - 183.0 + away
        easting, northing = grid.forward(latitude, longitude)
        expected = snyder(latitude, away)
        assert (easting, northing - (0 if grid.north else 1e7)) == pytest.approx(expected, abs=0.005)
        found = grid.inverse(easting, northing)
        assert found[0] == pytest.approx(latitude, abs=1e-10)
        assert (found[1] - longitude + 180) % 360 - 180 == pytest.approx(0.0, abs=1e-9)
        further = grid.forward(latitude + 1e-5, longitude)
        north = atan2(further[0] - easting, further[1] - northing)
        assert grid.convergence(latitude, longitude) == pytest.approx(-north, abs=1e-6)


@pytest.mark.parametrize(
    ("latitude", "longitude", "zone"),
    [
        (10, -180, 1),
        (10, 179.9, 60),
        (10, 180, 1),
        (60, 5, 32),
        (60, 2.9, 31),
        (73, 8.9, 31),
        (73, 9.1, 33),
        (83, 34, 37),
    ],
)
def test_zones(latitude: float, longitude: float, zone: int) -> None:
    assert Grid.at(latitude, longitude).zone == zone


def test_a_grid_goes_on_beyond_its_zone_and_the_equator() -> None:
    grid = Grid(31, north=True)
    assert grid.inverse(*grid.forward(-1.0, 7.5)) == pytest.approx((-1.0, 7.5))
    assert grid.forward(-1.0, 7.5)[1] < 0.0


@pytest.mark.parametrize("place", [(85.0, 0.0), (-80.1, 0.0), (nan, 0.0), (91.0, 0.0), (0.0, inf), (0.0, 1e5)])
def test_places_without_utm(place: tuple[float, float]) -> None:
    with pytest.raises(UtmError):
        Grid.at(*place)


@pytest.mark.parametrize("place", [(90.0, 3.0), (0.0, 93.0), (0.0, -177.0), (nan, 0.0)])
def test_places_too_far_from_a_grid(place: tuple[float, float]) -> None:
    with pytest.raises(UtmError):
        Grid(31, north=True).forward(*place)


@pytest.mark.parametrize("easting", [2.6e7, 4e7, 1e9, -1e12, 1e300, inf, nan])
def test_there_are_no_degrees_of_absurd_positions(easting: float) -> None:
    assert all(map(isnan, Grid(31, north=True).inverse(easting, 0.0)))
