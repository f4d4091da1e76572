"""Converts between degrees and metres east and north of a place, on a plane that touches the Earth there. Pure.

Uses the WGS 84 ellipsoid. Unlike in UTM, the axes point exactly east and north at the origin, and distances near it are
not scaled.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, degrees, hypot, radians, sin, sqrt
from typing import Any

import numpy as np

from pyros1.robot_nodes.robot_localization.motion import Array
from pyros1.robot_nodes.robot_localization.utm import FLATTENING, SEMI_MAJOR_AXIS, UtmError, check_degrees

MAX_DISTANCE = 1_000_000.0
"""Maximum distance from the origin in metres; farther away, the plane is too far from the Earth's surface."""

_E2 = FLATTENING * (2.0 - FLATTENING)
_STEPS = 10


@dataclass(frozen=True)
class LocalPlane:
    """The plane that touches the Earth at a place.

    Attributes:
        latitude, longitude: the place where the plane touches the Earth, in degrees.
        altitude: the place's height above the ellipsoid in metres; all positions are assumed to be at this height.
    """

    latitude: float
    longitude: float
    altitude: float = 0.0

    def forward(self, latitude: float, longitude: float) -> tuple[float, float]:
        """Return the distances in metres, east and north of the origin, of a position in degrees.

        Raises:
            UtmError: the position is not on Earth, or too far away.
        """
        check_degrees(latitude, longitude)
        away = _to_cartesian(latitude, longitude, self.altitude) - self._origin
        if np.linalg.norm(away) > MAX_DISTANCE:
            raise UtmError(f"latitude {latitude:.3f}, longitude {longitude:.3f} is too far from {self.name}")
        east, north, _ = (self._axes @ away).tolist()
        return east, north

    def inverse(self, east: float, north: float) -> tuple[float, float]:
        """Return the latitude and longitude in degrees of a position in metres east and north of the origin."""
        up, latitude, longitude = 0.0, self.latitude, self.longitude
        for _ in range(_STEPS):  # moves up or down until the place has the plane's altitude
            place = self._origin + np.array((east, north, up)) @ self._axes
            latitude, longitude, altitude = _to_degrees(*place.tolist())
            up += self.altitude - altitude
        return latitude, longitude

    def convergence(self, latitude: float, longitude: float) -> float:
        """Return 0.0: the plane's north is true north where it touches the Earth."""
        return 0.0

    @property
    def name(self) -> str:
        """The name of the coordinate system, for the log and errors."""
        return f"the local plane at latitude {self.latitude:.7f}, longitude {self.longitude:.7f}"

    @property
    def _origin(self) -> Array:
        origin: Array = _to_cartesian(self.latitude, self.longitude, self.altitude)
        return origin

    @property
    def _axes(self) -> Array:
        """East, north and up as rows (3, 3)."""
        phi, lam = radians(self.latitude), radians(self.longitude)
        return np.array(
            [
                [-sin(lam), cos(lam), 0.0],
                [-sin(phi) * cos(lam), -sin(phi) * sin(lam), cos(phi)],
                [cos(phi) * cos(lam), cos(phi) * sin(lam), sin(phi)],
            ]
        )


def _to_cartesian(latitude: float, longitude: float, altitude: float) -> Any:
    """Return the position (3,) relative to the Earth's centre in metres."""
    phi, lam = radians(latitude), radians(longitude)
    normal = SEMI_MAJOR_AXIS / sqrt(1.0 - _E2 * sin(phi) ** 2)
    across = (normal + altitude) * cos(phi)
    return np.array((across * cos(lam), across * sin(lam), (normal * (1.0 - _E2) + altitude) * sin(phi)))


def _to_degrees(x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return the latitude, longitude and altitude of a position relative to the Earth's centre."""
    across = hypot(x, y)
    phi = atan2(z, across * (1.0 - _E2))
    for _ in range(_STEPS):  # each step makes the error 150 times smaller
        normal = SEMI_MAJOR_AXIS / sqrt(1.0 - _E2 * sin(phi) ** 2)
        phi = atan2(z + _E2 * normal * sin(phi), across)
    normal = SEMI_MAJOR_AXIS / sqrt(1.0 - _E2 * sin(phi) ** 2)
    altitude = across * cos(phi) + z * sin(phi) - normal * (1.0 - _E2 * sin(phi) ** 2)
    return degrees(phi), degrees(atan2(y, x)), altitude
