"""Markers that a topic has added and not deleted (https://wiki.ros.org/rviz/DisplayTypes/Marker). Pure.

Unlike other messages, markers add up: each has a namespace and a number, takes the place of the one that had these, and
stays until it is deleted or its lifetime has passed.
"""

from __future__ import annotations

import math
from typing import Any

from pyros1.web.scene.shape import GREATEST

MOST_MARKERS = 20_000
"""Most markers of a topic; the oldest leave first."""
MOST_POINTS = 200_000
MOST_BYTES = 256 << 20
"""Most bytes that the markers of a topic take, about; beyond that, the oldest leave, but one always stays."""
_POINT = 112
"""Bytes of a point, or of a colour."""
_REST = 2_000
"""Bytes of a marker without its points and texts."""
_ADD, _DELETE, _DELETE_ALL = 0, 2, 3
_SHORTEST = 1e-4
"""Seconds; as in rviz, a marker with a shorter lifetime stays."""
_BACK = 0.5
"""Seconds by which the time goes back when a bag or a simulation begins again."""

Key = tuple[str, int]


class Markers:
    """The markers of a topic, and what has changed since somebody looked."""

    def __init__(self) -> None:
        # version, marker, bytes, when it came, and when it ends
        self._markers: dict[Key, tuple[int, Any, int, float, float]] = {}
        self._bytes = 0
        self._version = 0
        self._gone: dict[Key, int] = {}

    def add(self, markers: Any, now: float) -> None:
        """Take visualization_msgs/Marker messages at a time in seconds."""
        for marker in markers:
            self._version += 1
            if marker.action == _DELETE_ALL:
                for key in [key for key in self._markers if not marker.ns or key[0] == marker.ns]:
                    self._remove(key)
            elif marker.action == _DELETE:
                self._remove((marker.ns, marker.id))
            elif marker.action == _ADD:
                self._put(marker, now)

    def changes(self, seen: int, now: float) -> tuple[int, list[dict[str, Any]], list[list[Any]]]:
        """Return what has changed.

        Args:
            seen: the version up to which all is known; 0 for nothing.
            now: the time in seconds.

        Returns:
            The version now, the markers that are new or different, and the namespaces and numbers of those that left.
        """
        for key in [key for key, (*_, came, ends) in self._markers.items() if _has_ended(came, ends, now)]:
            self._version += 1
            self._remove(key)
        new = [as_json(marker) for version, marker, *_ in self._markers.values() if version > seen]
        gone = [list(key) for key, version in self._gone.items() if version > seen]
        return self._version, new, gone

    def frames(self) -> set[str]:
        """Return the frames of all markers."""
        return {_frame(marker) for _, marker, *_ in self._markers.values()}

    def _put(self, marker: Any, now: float) -> None:
        key = (marker.ns, marker.id)
        lifetime = marker.lifetime.to_sec()
        self._take_out(key)
        self._gone.pop(key, None)
        size = _size(marker)
        while self._markers and (len(self._markers) >= MOST_MARKERS or self._bytes + size > MOST_BYTES):
            self._remove(next(iter(self._markers)))
        self._markers[key] = (self._version, marker, size, now, now + lifetime if lifetime > _SHORTEST else math.inf)
        self._bytes += size

    def _remove(self, key: Key) -> None:
        if self._take_out(key):
            self._gone.pop(key, None)
            if len(self._gone) >= MOST_MARKERS:
                del self._gone[next(iter(self._gone))]
            self._gone[key] = self._version

    def _take_out(self, key: Key) -> bool:
        """Remove a marker without a word; return whether it was there."""
        known = self._markers.pop(key, None)
        if known is not None:
            self._bytes -= known[2]
        return known is not None


def _size(marker: Any) -> int:
    texts = (marker.ns, marker.text, marker.mesh_resource, marker.header.frame_id)
    return _REST + _POINT * (len(marker.points) + len(marker.colors)) + sum(map(len, texts))


def _has_ended(came: float, ends: float, now: float) -> bool:
    """Return whether a marker's lifetime is over; it is, too, if the time has gone back to before it came."""
    return ends < math.inf and not came - _BACK < now < ends


def as_json(marker: Any) -> dict[str, Any]:
    """Return a marker for JSON."""
    place, turn, size = marker.pose.position, marker.pose.orientation, marker.scale
    return {
        "ns": marker.ns,
        "id": marker.id,
        "type": marker.type,
        "frame": _frame(marker),
        "locked": bool(marker.frame_locked),
        "pose": _numbers(place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w),
        "scale": _numbers(size.x, size.y, size.z),
        "color": _colour(marker.color),
        "points": [_numbers(point.x, point.y, point.z) for point in marker.points[:MOST_POINTS]],
        "colors": [_colour(colour) for colour in marker.colors[:MOST_POINTS]],
        "text": marker.text[:1000],
        "mesh": marker.mesh_resource[:1000],
        "finite": _is_finite(marker),
        "materials": bool(marker.mesh_use_embedded_materials),
    }


def _is_finite(marker: Any) -> bool:
    """Return whether all numbers are finite, which rviz asks for, and places and sizes such that one can draw them."""
    places = [marker.pose.position, marker.scale, *marker.points[:MOST_POINTS]]
    if not all(abs(place.x) + abs(place.y) + abs(place.z) < GREATEST for place in places):
        return False
    turn = marker.pose.orientation
    colours = [marker.color, *marker.colors[:MOST_POINTS]]
    return math.isfinite(turn.x + turn.y + turn.z + turn.w) and all(
        math.isfinite(each.r + each.g + each.b + each.a) for each in colours
    )


def _frame(marker: Any) -> str:
    frame: str = marker.header.frame_id.lstrip("/")
    return frame


def _numbers(*values: float) -> list[float]:
    return [value if abs(value) < GREATEST else 0.0 for value in values]


def _colour(colour: Any) -> list[float]:
    return [
        min(1.0, max(0.0, value)) if math.isfinite(value) else 0.0 for value in (colour.r, colour.g, colour.b, colour.a)
    ]
