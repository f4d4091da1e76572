"""The local plane against the ellipsoid's radii of curvature and UTM."""

from __future__ import annotations

from math import cos, hypot, nan, radians, sin

import numpy as np
import pytest

from pyros1.robot_nodes.robot_localization.local_plane import LocalPlane
from pyros1.robot_nodes.robot_localization.utm import Grid, UtmError


def random_places(count: int) -> list[tuple[float, float, float]]:
    random = np.random.default_rng(0)
    return [(random.uniform(-79, 79), random.uniform(-180, 180), random.uniform(-100.0, 5000.0)) for _ in range(count)]


@pytest.mark.parametrize(("latitude", "longitude", "altitude"), random_places(20))
def test_a_step_is_as_long_as_the_radii_of_curvature_say(latitude: float, longitude: float, altitude: float) -> None:
    e2 = (2 - 1 / 298.257223563) / 298.257223563
    root = 1 - e2 * sin(radians(latitude)) ** 2
    meridian, normal = 6378137.0 * (1 - e2) / root**1.5, 6378137.0 / root**0.5
    plane, step = LocalPlane(latitude, longitude, altitude), 1e-4
    assert plane.forward(latitude, longitude) == pytest.approx((0.0, 0.0), abs=1e-6)
    north = radians(step) * (meridian + altitude)
    assert plane.forward(latitude + step, longitude) == pytest.approx((0.0, north), abs=1e-3)
    east = radians(step) * (normal + altitude) * cos(radians(latitude))
    assert plane.forward(latitude, longitude + step) == pytest.approx((east, 0.0), abs=1e-3)


@pytest.mark.parametrize(("latitude", "longitude", "altitude"), random_places(20))
def test_there_and_back(latitude: float, longitude: float, altitude: float) -> None:
    plane, random = LocalPlane(latitude, longitude, altitude), np.random.default_rng(1)
    for east, north in random.uniform(-50_000.0, 50_000.0, (5, 2)).tolist():
        place = plane.inverse(east, north)
        assert plane.forward(*place) == pytest.approx((east, north), abs=1e-6)


def test_near_the_origin_it_is_utm_turned_and_scaled() -> None:
    for latitude, longitude, _ in random_places(20):
        grid, plane = Grid.at(latitude, longitude), LocalPlane(latitude, longitude)
        other = latitude + 0.005, longitude + 0.005
        here, there = grid.forward(latitude, longitude), grid.forward(*other)
        on_grid, turn = complex(there[0] - here[0], there[1] - here[1]), grid.convergence(latitude, longitude)
        expected = on_grid * complex(cos(turn), -sin(turn))
        east, north = plane.forward(*other)
        assert hypot(east - expected.real, north - expected.imag) < 1.1e-3 * abs(expected)


@pytest.mark.parametrize(("latitude", "longitude"), [(48.0, 60.0), (-48.0, -170.0), (nan, 10.0), (91.0, 10.0)])
def test_what_is_far_away_or_not_on_earth(latitude: float, longitude: float) -> None:
    with pytest.raises(UtmError, match=r"too far from the local plane at latitude 48\.0|not degrees on Earth"):
        LocalPlane(48.0, 10.0).forward(latitude, longitude)
