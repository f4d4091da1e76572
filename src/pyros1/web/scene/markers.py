"""Keeps the current markers on a topic (no I/O).

Unlike other messages, markers accumulate: a marker replaces the earlier marker with the same namespace and id, and
stays until it is deleted or its lifetime has passed. See https://wiki.ros.org/rviz/DisplayTypes/Marker.
"""

from __future__ import annotations

import math
from typing import Any

from pyros1.web.scene.shape import MAX_MAGNITUDE

MAX_MARKERS = 20_000
"""Maximum number of markers per topic; beyond that, the oldest are removed."""
MAX_POINTS = 200_000
MAX_BYTES = 256 << 20
"""Approximate maximum size in bytes of a topic's markers; beyond that, the oldest are removed, but never the newest."""
_POINT_SIZE = 112
"""Approximate size of a point, or of a colour, in bytes."""
_MARKER_OVERHEAD = 2_000
"""Approximate size of a marker without its points and strings, in bytes."""
_ADD, _DELETE, _DELETE_ALL = 0, 2, 3
_MIN_LIFETIME = 1e-4
"""Minimum lifetime in seconds; as in rviz, a marker with a shorter lifetime never expires."""
_MAX_BACKWARD_STEP = 0.5
"""Seconds: if the time jumps back by more than this, a bag or a simulation has restarted."""

MarkerKey = tuple[str, int]


class Markers:
    """The markers on a topic, and the changes to them since any earlier version."""

    def __init__(self) -> None:
        # (version, marker, size in bytes, time when it was added, time when it expires)
        self._markers: dict[MarkerKey, tuple[int, Any, int, float, float]] = {}
        self._total_size = 0
        self._version = 0
        self._removed: dict[MarkerKey, int] = {}

    def apply(self, markers: Any, now: float) -> None:
        """Process visualization_msgs/Marker messages; ``now`` is their time of arrival in seconds."""
        for marker in markers:
            self._version += 1
            if marker.action == _DELETE_ALL:
                for key in [key for key in self._markers if not marker.ns or key[0] == marker.ns]:
                    self._remove(key)
            elif marker.action == _DELETE:
                self._remove((marker.ns, marker.id))
            elif marker.action == _ADD:
                self._put(marker, now)

    def changes(self, known_version: int, now: float) -> tuple[int, list[dict[str, Any]], list[list[Any]]]:
        """Return the changes since a version.

        Args:
            known_version: the version that the caller knows; 0 if it knows nothing.
            now: the time in seconds.

        Returns:
            The current version, the new or changed markers, and the namespace and id of each removed marker.
        """
        for key in [
            key for key, (*_, added_at, expires_at) in self._markers.items() if _has_expired(added_at, expires_at, now)
        ]:
            self._version += 1
            self._remove(key)
        new = [as_json(marker) for version, marker, *_ in self._markers.values() if version > known_version]
        removed = [list(key) for key, version in self._removed.items() if version > known_version]
        return self._version, new, removed

    def frames(self) -> set[str]:
        """Return the frames of all markers."""
        return {_frame(marker) for _, marker, *_ in self._markers.values()}

    def _put(self, marker: Any, now: float) -> None:
        key = (marker.ns, marker.id)
        lifetime = marker.lifetime.to_sec()
        self._discard(key)
        self._removed.pop(key, None)
        size = _estimate_size(marker)
        while self._markers and (len(self._markers) >= MAX_MARKERS or self._total_size + size > MAX_BYTES):
            self._remove(next(iter(self._markers)))
        self._markers[key] = (
            self._version,
            marker,
            size,
            now,
            now + lifetime if lifetime > _MIN_LIFETIME else math.inf,
        )
        self._total_size += size

    def _remove(self, key: MarkerKey) -> None:
        if self._discard(key):
            self._removed.pop(key, None)
            if len(self._removed) >= MAX_MARKERS:
                del self._removed[next(iter(self._removed))]
            self._removed[key] = self._version

    def _discard(self, key: MarkerKey) -> bool:
        """Remove a marker without recording the removal; return whether the marker existed."""
        entry = self._markers.pop(key, None)
        if entry is not None:
            self._total_size -= entry[2]
        return entry is not None


def _estimate_size(marker: Any) -> int:
    texts = (marker.ns, marker.text, marker.mesh_resource, marker.header.frame_id)
    return _MARKER_OVERHEAD + _POINT_SIZE * (len(marker.points) + len(marker.colors)) + sum(map(len, texts))


def _has_expired(added_at: float, expires_at: float, now: float) -> bool:
    """Return whether a marker has expired, or the time has jumped back to before the marker was added."""
    return expires_at < math.inf and not added_at - _MAX_BACKWARD_STEP < now < expires_at


def as_json(marker: Any) -> dict[str, Any]:
    """Return a marker as JSON for a page."""
    position, orientation, size = marker.pose.position, marker.pose.orientation, marker.scale
    return {
        "ns": marker.ns,
        "id": marker.id,
        "type": marker.type,
        "frame": _frame(marker),
        "locked": bool(marker.frame_locked),
        "pose": _finite_or_zero(
            position.x, position.y, position.z, orientation.x, orientation.y, orientation.z, orientation.w
        ),
        "scale": _finite_or_zero(size.x, size.y, size.z),
        "color": _rgba(marker.color),
        "points": [_finite_or_zero(point.x, point.y, point.z) for point in marker.points[:MAX_POINTS]],
        "colors": [_rgba(colour) for colour in marker.colors[:MAX_POINTS]],
        "text": marker.text[:1000],
        "mesh": marker.mesh_resource[:1000],
        "finite": _is_finite(marker),
        "materials": bool(marker.mesh_use_embedded_materials),
    }


def _is_finite(marker: Any) -> bool:
    """Return whether a marker's numbers are finite, as rviz requires, and its positions and size can be drawn."""
    positions = [marker.pose.position, marker.scale, *marker.points[:MAX_POINTS]]
    if not all(abs(position.x) + abs(position.y) + abs(position.z) < MAX_MAGNITUDE for position in positions):
        return False
    orientation = marker.pose.orientation
    colours = [marker.color, *marker.colors[:MAX_POINTS]]
    return math.isfinite(orientation.x + orientation.y + orientation.z + orientation.w) and all(
        math.isfinite(colour.r + colour.g + colour.b + colour.a) for colour in colours
    )


def _frame(marker: Any) -> str:
    frame: str = marker.header.frame_id.lstrip("/")
    return frame


def _finite_or_zero(*values: float) -> list[float]:
    return [value if abs(value) < MAX_MAGNITUDE else 0.0 for value in values]


def _rgba(colour: Any) -> list[float]:
    return [
        min(1.0, max(0.0, value)) if math.isfinite(value) else 0.0 for value in (colour.r, colour.g, colour.b, colour.a)
    ]
