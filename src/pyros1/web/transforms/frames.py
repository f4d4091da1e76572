"""Describes the tree of coordinate frames published on /tf and /tf_static, with publishers, rates and ages (no I/O)."""

from __future__ import annotations

from collections import deque
from typing import Any

MAX_FRAMES = 2_000
"""Maximum number of frames; transforms of further frames are only counted."""
_RATE_WINDOW = 50
"""Number of messages over which a rate is measured."""
_MAX_SOURCES = 8
"""Maximum number of pairs (publisher, parent) kept per frame."""
_MAX_BACKWARD_STEP = 0.5
"""Seconds: if the time jumps back by more than this, a bag or a simulation has restarted."""


class _Frame:
    def __init__(self) -> None:
        self.static = False
        self.sources: dict[tuple[str, str], float] = {}  # (publisher, parent) -> time of the last message
        self.arrivals: deque[float] = deque(maxlen=_RATE_WINDOW)
        self.stamp = 0.0
        self.transform: list[float] = []


class Frames:
    """The frames whose transforms are published, and the problems with them."""

    def __init__(self) -> None:
        self._frames: dict[str, _Frame] = {}
        self._newest_time = float("-inf")
        self.ignored = 0

    def add(self, transforms: Any, publisher: str, static: bool, now: float) -> None:
        """Process the transforms of a tf2_msgs/TFMessage.

        Args:
            transforms: geometry_msgs/TransformStamped messages.
            publisher: name of the publishing node.
            static: whether the message was published on /tf_static.
            now: the time of arrival in seconds.
        """
        if not static:  # static transforms are latched, so they may be from an earlier time
            self._advance_time(now)
        for stamped_transform in transforms:
            child, parent = stamped_transform.child_frame_id.lstrip("/"), stamped_transform.header.frame_id.lstrip("/")
            frame = self._frames.get(child)
            if frame is None:
                if len(self._frames) >= MAX_FRAMES:
                    self.ignored += 1
                    continue
                frame = self._frames[child] = _Frame()
            frame.static = static
            source = (publisher, parent)
            frame.sources.pop(source, None)
            while len(frame.sources) >= _MAX_SOURCES:
                del frame.sources[next(iter(frame.sources))]
            frame.sources[source] = now
            frame.arrivals.append(now)
            frame.stamp = stamped_transform.header.stamp.to_sec()
            translation, rotation = stamped_transform.transform.translation, stamped_transform.transform.rotation
            frame.transform = [
                translation.x,
                translation.y,
                translation.z,
                rotation.x,
                rotation.y,
                rotation.z,
                rotation.w,
            ]

    def describe(self, now: float, recent_seconds: float = 5.0) -> dict[str, Any]:
        """Return all frames as JSON.

        Args:
            now: the time in seconds.
            recent_seconds: if two parents of a frame were published within this many seconds, this is reported as a
                problem.

        Returns:
            - frames: a list of name, parent, publishers, static, hz or null, age in seconds or null, transform (x, y, z
              in metres, quaternion x, y, z, w) and problem, sorted by name
            - roots: names of frames without a parent
            - ignored: number of transforms that were ignored, as there are too many frames
        """
        self._advance_time(now)
        parents = {name: self._newest_parent(frame) for name, frame in self._frames.items()}
        frames = []
        for name, frame in sorted(self._frames.items()):
            recent_sources = [
                pair for pair, last_time in frame.sources.items() if frame.static or last_time > now - recent_seconds
            ]
            recent_sources = recent_sources or [next(reversed(frame.sources))]
            frames.append(
                {
                    "name": name,
                    "parent": parents[name],
                    "publishers": sorted({publisher for publisher, _ in recent_sources}),
                    "static": frame.static,
                    "hz": None if frame.static else _rate(frame.arrivals, now),
                    "age": None if frame.static else max(0.0, now - frame.stamp),
                    "transform": frame.transform,
                    "problem": _find_problem(name, {parent for _, parent in recent_sources}, parents),
                }
            )
        roots = sorted({parent for parent in parents.values() if parent not in parents})
        return {"frames": frames, "roots": roots, "ignored": self.ignored}

    def _advance_time(self, now: float) -> None:
        if now < self._newest_time - _MAX_BACKWARD_STEP:
            # Earlier data would now be in the future: only static frames are kept.
            self._frames = {name: frame for name, frame in self._frames.items() if frame.static}
            self._newest_time = now
        self._newest_time = max(self._newest_time, now)

    @staticmethod
    def _newest_parent(frame: _Frame) -> str:
        return next(reversed(frame.sources))[1]


def _rate(arrivals: deque[float], now: float) -> float:
    if len(arrivals) < 2 or now - arrivals[-1] > max(2.0, 5 * (arrivals[-1] - arrivals[0]) / (len(arrivals) - 1)):
        return 0.0
    duration = arrivals[-1] - arrivals[0]
    return (len(arrivals) - 1) / duration if duration > 0 else 0.0


def _find_problem(name: str, claimed_parents: set[str], parents: dict[str, str]) -> str:
    if len(claimed_parents) > 1:
        return f"has {len(claimed_parents)} parents: {', '.join(sorted(claimed_parents))}; a frame can have only one"
    visited = {name}
    ancestor = parents[name]
    while ancestor in parents:
        if ancestor in visited:
            return f"is in a loop with {ancestor}" if ancestor != name else "is its own ancestor"
        visited.add(ancestor)
        ancestor = parents[ancestor]
    return ""
