"""Converts between latitude and longitude and UTM coordinates in metres. Pure.

Uses Krüger's series to the fourth order on the WGS 84 ellipsoid, as in C. F. F. Karney, "Transverse Mercator with an
accuracy of a few nanometers" (2011); the error is far below a millimetre in a zone and its neighbours.
"""

from __future__ import annotations

import re
from cmath import cos as complex_cos
from cmath import phase
from cmath import sin as complex_sin
from dataclasses import dataclass
from math import asin, asinh, atan2, atanh, cos, degrees, hypot, nan, radians, sin, sinh, sqrt, tan, tanh

from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line

MIN_LATITUDE, MAX_LATITUDE = -80.0, 84.0
SEMI_MAJOR_AXIS, FLATTENING = 6_378_137.0, 1 / 298.257_223_563
"""The semi-major axis in metres, and the flattening, of the WGS 84 ellipsoid."""

_BANDS = "CDEFGHJKLMNPQRSTUVWX"
_SCALE, _FALSE_EASTING, _FALSE_NORTHING = 0.9996, 500_000.0, 10_000_000.0
_N = FLATTENING / (2.0 - FLATTENING)
_ECCENTRICITY = 2.0 * sqrt(_N) / (1.0 + _N)
_UNIT = _SCALE * SEMI_MAJOR_AXIS / (1.0 + _N) * (1.0 + _N**2 / 4.0 + _N**4 / 64.0)
_ALPHA = (
    _N / 2 - 2 * _N**2 / 3 + 5 * _N**3 / 16 + 41 * _N**4 / 180,
    13 * _N**2 / 48 - 3 * _N**3 / 5 + 557 * _N**4 / 1440,
    61 * _N**3 / 240 - 103 * _N**4 / 140,
    49561 * _N**4 / 161280,
)
_BETA = (
    _N / 2 - 2 * _N**2 / 3 + 37 * _N**3 / 96 - _N**4 / 360,
    _N**2 / 48 + _N**3 / 15 - 437 * _N**4 / 1440,
    17 * _N**3 / 480 - 37 * _N**4 / 840,
    4397 * _N**4 / 161280,
)
_MAX_AWAY = 6.0  # radians from the meridian: more than any valid coordinates, and sinh does not overflow yet
_MAX_METRES = 2e7  # so that `inverse` has a result
_LATITUDE_STEPS = 10  # each step makes the error 150 times smaller


class UtmError(Error):
    """There are no UTM coordinates for a latitude and longitude."""


@dataclass(frozen=True)
class Grid:
    """The coordinates of one zone on one hemisphere.

    Attributes:
        zone: 1 to 60.
        north: whether northings are counted from the equator; otherwise 10,000 km are added.
    """

    zone: int
    north: bool

    @classmethod
    def at(cls, latitude: float, longitude: float) -> Grid:
        """Return the grid to use at a latitude and longitude in degrees.

        Raises:
            UtmError: the place is too near to a pole, or not on Earth.
        """
        check_degrees(latitude, longitude)
        if not MIN_LATITUDE <= latitude < MAX_LATITUDE:
            raise UtmError(
                f"at a latitude of {latitude:.3f} there is no UTM, only from {MIN_LATITUDE} to {MAX_LATITUDE}"
            )
        longitude = (longitude + 180.0) % 360.0 - 180.0
        zone = int((longitude + 180.0) // 6.0) + 1
        if 56.0 <= latitude < 64.0 and 3.0 <= longitude < 12.0:  # Norway
            zone = 32
        if latitude >= 72.0 and 0.0 <= longitude < 42.0:  # Svalbard
            zone = 31 + 2 * int((longitude + 3.0) // 12.0)
        return cls(zone, latitude >= 0.0)

    @classmethod
    def named(cls, zone: str) -> Grid:
        """Return the grid for a zone number and latitude band, such as ``31U``.

        Raises:
            UtmError: the name is not valid.
        """
        number, band = zone[:-1], zone[-1:].upper()
        if not (re.fullmatch("[0-9]{1,2}", number) and 1 <= int(number) <= 60 and band and band in _BANDS):
            text = "a UTM zone is a number from 1 to 60 and the letter of a latitude band, such as 31U, not %s"
            raise UtmError(text % one_line(repr(zone), 50))
        return cls(int(number), band >= "N")

    @property
    def name(self) -> str:
        """The name of the coordinate system, for the log and errors."""
        return f"UTM zone {self.zone} {'north' if self.north else 'south'}"

    def forward(self, latitude: float, longitude: float) -> tuple[float, float]:
        """Return the easting and northing in metres of a latitude and longitude in degrees.

        Raises:
            UtmError: the place is a pole, on the other side of the Earth, or not on Earth.
        """
        zeta = self._to_sphere(latitude, longitude)
        z = zeta + sum(factor * complex_sin(2 * number * zeta) for number, factor in enumerate(_ALPHA, 1))
        return _FALSE_EASTING + _UNIT * z.imag, (0.0 if self.north else _FALSE_NORTHING) + _UNIT * z.real

    def inverse(self, easting: float, northing: float) -> tuple[float, float]:
        """Return the latitude and longitude in degrees of an easting and northing in metres; nan if they are absurd."""
        z = complex(northing - (0.0 if self.north else _FALSE_NORTHING), easting - _FALSE_EASTING) / _UNIT
        if not abs(z.imag) <= _MAX_AWAY:  # for example, from a filter that has diverged
            return nan, nan
        zeta = z - sum(factor * complex_sin(2 * number * z) for number, factor in enumerate(_BETA, 1))
        if not abs(zeta.imag) <= _MAX_AWAY:
            return nan, nan
        east = sinh(zeta.imag)
        conformal = asinh(sin(zeta.real) / hypot(east, cos(zeta.real)))
        sine = tanh(conformal)
        for _ in range(_LATITUDE_STEPS):
            sine = tanh(conformal + _ECCENTRICITY * atanh(_ECCENTRICITY * sine))
        longitude = self._meridian + degrees(atan2(east, cos(zeta.real)))
        return degrees(asin(sine)), (longitude + 180.0) % 360.0 - 180.0

    def convergence(self, latitude: float, longitude: float) -> float:
        """Return the bearing of the grid's north in radians, clockwise from true north.

        Raises:
            UtmError: see `forward`.
        """
        zeta = self._to_sphere(latitude, longitude)
        tangent = _conformal_tangent(latitude)
        on_sphere = atan2(tangent * tan(radians(self._from_meridian(longitude))), hypot(1.0, tangent))
        slope = 1 + sum(2 * number * factor * complex_cos(2 * number * zeta) for number, factor in enumerate(_ALPHA, 1))
        return on_sphere - phase(slope)

    @property
    def _meridian(self) -> float:
        return 6.0 * self.zone - 183.0

    def _from_meridian(self, longitude: float) -> float:
        return (longitude - self._meridian + 180.0) % 360.0 - 180.0

    def _to_sphere(self, latitude: float, longitude: float) -> complex:
        check_degrees(latitude, longitude)
        angle, tangent = radians(self._from_meridian(longitude)), _conformal_tangent(latitude)
        if abs(latitude) > 89.9 or abs(angle) > 1.5:
            raise UtmError(f"latitude {latitude:.3f}, longitude {longitude:.3f} is too far from UTM zone {self.zone}")
        return complex(atan2(tangent, cos(angle)), asinh(sin(angle) / hypot(tangent, cos(angle))))


def _conformal_tangent(latitude: float) -> float:
    sine = sin(radians(max(-89.99, min(latitude, 89.99))))
    return sinh(atanh(sine) - _ECCENTRICITY * atanh(_ECCENTRICITY * sine))


def check_degrees(latitude: float, longitude: float) -> None:
    """Raise a `UtmError` if this is not a place on Earth."""
    if not (abs(latitude) <= 90.0 and abs(longitude) <= 540.0):  # nan, too
        raise UtmError(f"latitude {latitude}, longitude {longitude} are not degrees on Earth")


def check_metres(*metres: float) -> None:
    """Raise a `UtmError` if a number is too large for the Earth, or nan."""
    if not all(abs(each) <= _MAX_METRES for each in metres):
        raise UtmError(f"coordinates out of range: {', '.join(f'{each:g}' for each in metres)} (in metres)")
