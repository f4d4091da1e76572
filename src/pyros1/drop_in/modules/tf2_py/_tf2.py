"""BufferCore: transforms over time, without waiting. In stock ROS 1, this is a C++ extension."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rospy.rostime import Duration, Time

from pyros1.ground.timing import TVal
from pyros1.tf.buffer import Buffer
from pyros1.tf.fast_decoder import Row

_TEN_SECONDS = Duration(10)
_NO_TIME = "time must have a to_sec method, e.g. rospy.Time or rospy.Duration"


class BufferCore:
    """A buffer for the transforms of the last few seconds, with lookups between any two frames.

    Thread-safe. Frame names have no leading slash. Times are `rospy.Time`; time 0 is the latest time at which all
    transforms between two frames are known.

    Args:
        cache_time: how long transforms are kept: a Duration, counted back from the newest transform of the same frame.
    """

    def __init__(self, cache_time: Any = _TEN_SECONDS) -> None:
        self._core = Buffer(_require_time(cache_time), time_class=Time)

    def set_transform(self, transform: Any, authority: str, /) -> None:
        """Add a geometry_msgs/TransformStamped from the node ``authority``. An invalid transform is reported."""
        self._core.set_transforms((transform,), authority)

    def set_transform_static(self, transform: Any, authority: str, /) -> None:
        """Add a static transform."""
        self._core.set_transforms((transform,), authority, static=True)

    def set_transforms(self, transforms: Iterable[Any], authority: str, static: bool) -> None:
        """Add several transforms (a pyros1 extension: waiting lookups are woken only once)."""
        self._core.set_transforms(transforms, authority, static=static)

    def set_rows(self, rows: Iterable[Row], authority: str, static: bool) -> None:
        """Add several transforms received by a listener (a pyros1 extension)."""
        self._core.set_rows(rows, authority, static=static)

    def clear(self, *_: Any) -> None:
        """Remove all transforms except static ones."""
        self._core.clear()

    def lookup_transform_core(self, target_frame: str, source_frame: str, time: Any) -> Any:
        """Return the pose of ``source_frame`` in ``target_frame``, as a geometry_msgs/TransformStamped.

        Raises:
            TransformException: the transform is not available; one of the subclasses in this package.
            TypeError: an argument has the wrong type.
        """
        return self._core.lookup_transform(target_frame, source_frame, _require_time(time))

    def lookup_transform_full_core(
        self, target_frame: str, target_time: Any, source_frame: str, source_time: Any, fixed_frame: str
    ) -> Any:
        """Return the pose of ``source_frame`` at ``source_time`` in ``target_frame`` at ``target_time``.

        ``fixed_frame`` is assumed not to move between the two times. For the exceptions, see `lookup_transform_core`.
        """
        return self._core.lookup_transform_full(
            target_frame, _require_time(target_time), source_frame, _require_time(source_time), fixed_frame
        )

    def can_transform_core(self, target_frame: str, source_frame: str, time: Any) -> tuple[int, str]:
        """Return (1, "") if `lookup_transform_core` would succeed, else (0, reason)."""
        reason = self._core.why_not(target_frame, source_frame, _require_time(time))
        return (1, "") if reason is None else (0, reason)

    def can_transform_full_core(
        self, target_frame: str, target_time: Any, source_frame: str, source_time: Any, fixed_frame: str
    ) -> tuple[int, str]:
        """Return (1, "") if `lookup_transform_full_core` would succeed, else (0, reason)."""
        reason = self._core.why_not_full(
            target_frame, _require_time(target_time), source_frame, _require_time(source_time), fixed_frame
        )
        return (1, "") if reason is None else (0, reason)

    def get_latest_common_time(self, target_frame: str, source_frame: str, /) -> Any:
        """Return the latest time at which all transforms between the two are known; 0 if all of them are static.

        Raises:
            TransformException: a frame does not exist, or the frames are not connected.
        """
        return self._core.get_latest_common_time(target_frame, source_frame)

    def all_frames_as_string(self) -> str:
        """Return a string with a line for each frame that has a parent."""
        return self._core.all_frames_as_string()

    def all_frames_as_yaml(self, *_: Any) -> str:
        """Return parent, broadcaster, rate and times of each frame as YAML."""
        return self._core.all_frames_as_yaml()

    def _allFramesAsDot(self, time: Any = None) -> str:
        """Return the tree in Graphviz's dot language, with ages if a time is passed."""
        return self._core.all_frames_as_dot(None if time is None else _require_time(time).to_sec())

    def _frameExists(self, frame: str, /) -> bool:
        """Return whether a frame with that name is known."""
        if not isinstance(frame, str):
            raise TypeError(f"argument 1 must be str, not {type(frame).__name__}")
        return self._core.has_frame(frame)

    def _getFrameStrings(self, *_: Any) -> list[str]:
        """Return the names of all frames."""
        return self._core.frames()

    def _chain(
        self, target_frame: str, target_time: Any, source_frame: str, source_time: Any, fixed_frame: str
    ) -> list[str]:
        """Return the names of the frames from source through ``fixed_frame`` to target, including both."""
        times = _require_time(target_time), _require_time(source_time)
        return self._core.chain_full(target_frame, times[0], source_frame, times[1], fixed_frame)

    def _wait(self, timeout: float, target_frame: str, source_frame: str, time: Any) -> bool:
        """Wait up to ``timeout`` seconds of wall time for a transform; return whether it is available."""
        return self._core.can_transform(target_frame, source_frame, _require_time(time), timeout)

    def _wait_full(
        self,
        timeout: float,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
    ) -> bool:
        """Wait like `_wait`."""
        times = _require_time(target_time), _require_time(source_time)
        return self._core.can_transform_full(target_frame, times[0], source_frame, times[1], fixed_frame, timeout)


def _require_time(time: Any) -> Any:
    """Return a time or duration; raise TypeError for other types, including numbers of seconds."""
    if isinstance(time, TVal):
        return time
    if not hasattr(time, "to_sec"):
        raise TypeError(_NO_TIME)
    return Duration.from_sec(time.to_sec())
