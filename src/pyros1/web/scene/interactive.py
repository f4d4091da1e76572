"""Keeps the current interactive markers of the servers on a topic (no I/O).

A server publishes all its markers, latched, on ``TOPIC/update_full``, and changes on ``TOPIC/update``. The sequence
numbers in these messages show which of them belong together. See https://wiki.ros.org/interactive_markers.
"""

from __future__ import annotations

from typing import Any

from pyros1.web.scene.markers import as_json
from pyros1.web.scene.shape import MAX_MAGNITUDE

MAX_MARKERS = 1_000
"""Maximum number of interactive markers per topic; further markers are ignored."""
MAX_POINTS = 500_000
"""Maximum total number of points and colours in a topic's markers; a marker that would exceed this is ignored."""
MAX_CONTROLS = 200
MAX_MENU_ENTRIES = 500
_MAX_SERVERS = 20
_SERVER_TIMEOUT = 10.0
"""Seconds without messages after which a server is assumed to be gone: servers send a keep-alive twice a second."""
_UPDATE = 1
_POSE_FIELDS = ("pose", "frame")

MarkerKey = tuple[str, str]
"""A server's name, and a marker's name."""


class InteractiveMarkers:
    """The interactive markers on a topic, and the changes to them since any earlier version."""

    def __init__(self) -> None:
        # Values: (version in which the marker was added or changed, marker).
        self._markers: dict[MarkerKey, tuple[int, dict[str, Any]]] = {}
        self._num_points: dict[MarkerKey, int] = {}
        self._moved: dict[MarkerKey, int] = {}  # version in which the marker was last moved
        self._removed: dict[MarkerKey, int] = {}  # version in which the marker was removed
        self._servers: dict[str, tuple[int, float]] = {}  # (newest sequence number, time of the last message)
        self._version = 0

    def init(self, message: Any, now: float) -> None:
        """Process a visualization_msgs/InteractiveMarkerInit; ``now`` is its time of arrival in seconds."""
        server = message.server_id
        if server not in self._servers and len(self._servers) >= _MAX_SERVERS:
            return
        previous = self._servers.get(server)
        if previous is not None and previous[0] == message.seq_num and any(key[0] == server for key in self._markers):
            self._servers[server] = (previous[0], now)
            return  # a repeated message: nothing has changed
        self._version += 1
        self._servers[server] = (message.seq_num, now)
        names = {marker.name for marker in message.markers}
        for key in [key for key in self._markers if key[0] == server and key[1] not in names]:
            self._remove(key)
        for marker in message.markers:
            self._put(server, marker)

    def update(self, message: Any, now: float) -> bool:
        """Process a visualization_msgs/InteractiveMarkerUpdate; return False if an earlier message was missed.

        ``now`` is its time of arrival in seconds.
        """
        previous = self._servers.get(message.server_id)
        if previous is None:
            return False
        sequence_number, _ = previous
        if message.type != _UPDATE:
            self._servers[message.server_id] = (sequence_number, now)
            return bool(message.seq_num <= sequence_number)
        if message.seq_num <= sequence_number:
            return True
        if message.seq_num != sequence_number + 1:
            return False
        self._version += 1
        self._servers[message.server_id] = (message.seq_num, now)
        for marker in message.markers:
            self._put(message.server_id, marker)
        for pose in message.poses:
            key = (message.server_id, pose.name)
            if key in self._markers:
                version, marker = self._markers[key]
                position = {"pose": pose_of(pose.pose), "frame": pose.header.frame_id.lstrip("/")}
                self._markers[key] = (version, marker | position)
                self._moved[key] = self._version
        for name in message.erases:
            self._remove((message.server_id, name))
        return True

    def remove_expired(self, now: float) -> None:
        """Remove servers that seem to be gone, with their markers."""
        for server in [
            server for server, (_, received_at) in self._servers.items() if now > received_at + _SERVER_TIMEOUT
        ]:
            del self._servers[server]
            self._version += 1
            for key in [key for key in self._markers if key[0] == server]:
                self._remove(key)

    def changes(self, known_version: int) -> tuple[int, list[dict[str, Any]], list[dict[str, Any]], list[list[str]]]:
        """Return the changes since a version.

        Args:
            known_version: the version that the caller knows; 0 if it knows nothing.

        Returns:
            The current version; the new or changed markers; "server", "name", "frame" and "pose" of markers that have
            only moved; and the server and name of each removed marker.
        """
        new = [marker for version, marker in self._markers.values() if version > known_version]
        moved = [
            {name: marker[name] for name in ("server", "name", *_POSE_FIELDS)}
            for key, (version, marker) in self._markers.items()
            if version <= known_version < self._moved.get(key, 0)
        ]
        removed = [list(key) for key, version in self._removed.items() if version > known_version]
        return self._version, new, moved, removed

    def _put(self, server: str, marker: Any) -> None:
        key = (server, marker.name)
        if key not in self._markers and len(self._markers) >= MAX_MARKERS:
            return
        points = sum(len(each.points) + len(each.colors) for control in marker.controls for each in control.markers)
        if sum(self._num_points.values()) - self._num_points.get(key, 0) + points > MAX_POINTS:
            return
        self._num_points[key] = points
        description = {"server": server, **_to_json(marker)}
        if key in self._markers:
            version, previous = self._markers[key]
            if previous == description:
                return
            # A server may resend a whole marker although only its pose has changed.
            if previous | {name: description[name] for name in _POSE_FIELDS} == description:
                self._markers[key], self._moved[key] = (version, description), self._version
                return
        self._removed.pop(key, None)
        self._moved.pop(key, None)
        self._markers[key] = (self._version, description)

    def _remove(self, key: MarkerKey) -> None:
        if self._markers.pop(key, None) is not None:
            self._num_points.pop(key, None)
            self._moved.pop(key, None)
            self._removed.pop(key, None)
            if len(self._removed) >= MAX_MARKERS:
                del self._removed[next(iter(self._removed))]
            self._removed[key] = self._version


def pose_of(pose: Any) -> list[float]:
    """Return a pose as x, y, z in metres and a quaternion x, y, z, w, with 0 in place of non-finite values."""
    position, orientation = pose.position, pose.orientation
    return _finite_or_zero(
        position.x, position.y, position.z, orientation.x, orientation.y, orientation.z, orientation.w
    )


def _finite_or_zero(*numbers: float) -> list[float]:
    return [number if abs(number) < MAX_MAGNITUDE else 0.0 for number in numbers]


def _to_json(marker: Any) -> dict[str, Any]:
    return {
        "name": marker.name,
        "description": marker.description[:1000],
        "frame": marker.header.frame_id.lstrip("/"),
        "locked": not marker.header.stamp,  # a stamp of 0 means that the marker moves with its frame
        "pose": pose_of(marker.pose),
        "scale": marker.scale if 0 < marker.scale < MAX_MAGNITUDE else 1.0,
        "menu": [
            {"id": entry.id, "parent": entry.parent_id, "title": entry.title[:300]}
            for entry in marker.menu_entries[:MAX_MENU_ENTRIES]
        ],
        "controls": [
            {
                "name": control.name,
                "turn": _finite_or_zero(
                    control.orientation.x, control.orientation.y, control.orientation.z, control.orientation.w
                ),
                "mode": control.interaction_mode,
                "facing": control.orientation_mode,
                "always": bool(control.always_visible),
                "independent": bool(control.independent_marker_orientation),
                "description": control.description[:300],
                "markers": [as_json(each) for each in control.markers[:MAX_CONTROLS]],
            }
            for control in marker.controls[:MAX_CONTROLS]
        ],
    }
