"""The buffer in which programs look up transforms; thread-safe."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterable
from time import monotonic
from typing import Any, NamedTuple, TypeVar

from pyros1.ground.errors import NodeShutdownError
from pyros1.ground.terminal_text import one_line
from pyros1.ground.timing import Time
from pyros1.msgs import load_message
from pyros1.tf.errors import ConnectivityException, ExtrapolationException, LookupException
from pyros1.tf.fast_decoder import Row
from pyros1.tf.frame import to_sec
from pyros1.tf.rotation import Transform
from pyros1.tf.tree import Tree
from pyros1.tf.tree_formats import as_dot, as_string, as_yaml

_T = TypeVar("_T")
_NS_PER_S = 1_000_000_000
_new_object = object.__new__
_RETRYABLE_ERRORS = (LookupException, ConnectivityException, ExtrapolationException)
"""Errors that may be resolved when further transforms arrive."""

When = Any
"""A Time (any object with secs and nsecs) or a number of seconds; None or 0 means the latest time."""

Span = Any
"""A timeout: a number of seconds or a Duration; None or 0 means do not wait."""


class FrameState(NamedTuple):
    """The state of one frame in a buffer.

    Attributes:
        name: the frame's name.
        parent: name of the parent frame; None for the root of a tree, and after `Buffer.clear`.
        authority: name of the node that sent the last transform.
        static: whether the transform is valid at all times.
        rate: transforms per second; 0 if there are fewer than two.
        latest, oldest: stamps in seconds of the newest and the oldest transform; 0 for a static transform.
        transforms: number of transforms in the buffer.
    """

    name: str
    parent: str | None
    authority: str
    static: bool
    rate: float
    latest: float
    oldest: float
    transforms: int


class Buffer:
    """Stores the transforms of the last few seconds, for lookups between any two frames.

    It is filled by a `TransformListener`, or with `set_transform`. Frame names have no leading slash.

    Args:
        cache_time: number of seconds of transforms to keep for each frame, counted back from the frame's newest one.
        warn: called with a message when a transform is ignored; if None, messages go to stderr until a listener is
            attached, and then to the log of the listener's node. When a frame has the same problem again, only the
            10th, 100th, ... time is reported.
        time_class: class of the times in results; called with seconds and nanoseconds.
    """

    def __init__(
        self,
        cache_time: Span = 10.0,
        *,
        warn: Callable[[str], object] | None = None,
        time_class: Callable[[int, int], Any] = Time,
    ) -> None:
        self.cache_time = _to_seconds(cache_time)
        self.warn = warn
        self._time_class = time_class
        self._tree = Tree(round(self.cache_time * _NS_PER_S))
        self._lock = threading.RLock()  # a signal handler may do a lookup while it interrupts a method of this object
        self._changed = threading.Condition(self._lock)
        self._num_waiting = 0
        self._clock: Callable[[], float] = monotonic
        self._waits_ended = False
        self._ignored_counts: dict[str, int] = {}
        self._transform_stamped_class: Any = load_message("geometry_msgs/TransformStamped")
        self._header_class: Any = load_message("std_msgs/Header")
        self._transform_class: Any = load_message("geometry_msgs/Transform")
        self._vector_class: Any = load_message("geometry_msgs/Vector3")
        self._quaternion_class: Any = load_message("geometry_msgs/Quaternion")

    # Filling ----------------------------------------------------------------------------------------------------------

    def set_transform(self, transform: Any, authority: str = "default_authority") -> None:
        """Add a transform.

        Args:
            transform: a geometry_msgs/TransformStamped.
            authority: name of the node that sent it.
        """
        self.set_transforms([transform], authority)

    def set_transform_static(self, transform: Any, authority: str = "default_authority") -> None:
        """Add a transform that is valid at all times."""
        self.set_transforms([transform], authority, static=True)

    def set_transforms(self, transforms: Iterable[Any], authority: str, *, static: bool = False) -> None:
        """Add several transforms; waiting lookups are woken once."""
        rows: list[Row] = []
        for stamped_transform in transforms:
            if not hasattr(stamped_transform, "child_frame_id"):
                raise TypeError(f"a transform must be a geometry_msgs/TransformStamped, not {stamped_transform!r:.80}")
            header = stamped_transform.header
            stamp = header.stamp
            transform = stamped_transform.transform
            v = transform.translation
            q = transform.rotation
            # Results contain floats, as in tf2, whatever numbers a program has set.
            numbers = (float(v.x), float(v.y), float(v.z), float(q.x), float(q.y), float(q.z), float(q.w))
            rows.append(
                (header.frame_id, stamped_transform.child_frame_id, stamp.secs * _NS_PER_S + stamp.nsecs, numbers)
            )
        self.set_rows(rows, authority, static=static)

    def set_rows(self, rows: Iterable[Row], authority: str, *, static: bool = False) -> None:
        """Add several transforms, given as `Row` tuples; waiting lookups are woken once."""
        with self._lock:
            problems = self._tree.insert_rows(rows, static, authority)
            if self._num_waiting:
                self._changed.notify_all()
        for problem in problems:
            self._warn_ignored(problem)

    def clear(self) -> None:
        """Remove all transforms except static ones."""
        with self._changed:
            self._tree.clear()

    def _warn_ignored(self, problem: str) -> None:
        """Report why a transform is ignored. A repeated problem is reported less and less often, since every transform
        may have it.
        """
        problem_key = problem.split(" at time ", maxsplit=1)[0].split(" in the transform ", maxsplit=1)[0]
        count = self._ignored_counts[problem_key] = self._ignored_counts.get(problem_key, 0) + 1
        if count > 1:
            if str(count).strip("0") != "1":
                return
            problem += f" ({count} times)"
        problem = one_line(problem)
        if self.warn is None:
            # Old and repeated data are warnings; all other problems are errors of the node that sent the transform.
            is_old_data = problem.startswith(("TF_OLD_DATA", "TF_REPEATED_DATA"))
            sys.stderr.write(f"{'Warning: ' if is_old_data else 'Error:   '}{problem}\n")
        else:
            self.warn(problem)

    # Lookups ----------------------------------------------------------------------------------------------------------

    def lookup_transform(self, target_frame: str, source_frame: str, time: When = None, timeout: Span = None) -> Any:
        """Return the pose of ``source_frame`` in ``target_frame``: the transform that converts data from source to
        target.

        Args:
            time: time of the transform; None or 0 for the latest time at which all transforms between the two frames
                are known.
            timeout: seconds to wait for the transform, of simulated time if the listener's node uses it; the wait ends
                early if that time jumps back to before its start, and with an error when that node shuts down.

        Returns:
            A geometry_msgs/TransformStamped.

        Raises:
            LookupException: a frame does not exist, or the tree has a loop.
            ConnectivityException: the frames are not connected.
            ExtrapolationException: there is no data for that time.
            InvalidArgumentException: a frame's name is empty or begins with a slash.
            NodeShutdownError: the node shut down during the wait.
        """
        time_ns = _to_nanoseconds(time)
        if not timeout:
            with self._lock:
                stamp, transform = self._tree.lookup(target_frame, source_frame, time_ns)
        else:
            stamp, transform = self._retry_until(
                lambda: self._tree.lookup(target_frame, source_frame, time_ns), timeout
            )
        return self._make_message(target_frame, source_frame, stamp, transform)

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: When,
        source_frame: str,
        source_time: When,
        fixed_frame: str,
        timeout: Span = None,
    ) -> Any:
        """Return the pose of ``source_frame`` at ``source_time`` in ``target_frame`` at ``target_time``.

        Args:
            fixed_frame: a frame that did not move in between, such as the map.
            timeout: as for `lookup_transform`, which also lists the errors.
        """
        arguments = (
            target_frame,
            _to_nanoseconds(target_time),
            source_frame,
            _to_nanoseconds(source_time),
            fixed_frame,
        )
        stamp, transform = self._retry_until(lambda: self._tree.lookup_full(*arguments), timeout)
        return self._make_message(target_frame, source_frame, stamp, transform)

    def can_transform(self, target_frame: str, source_frame: str, time: When = None, timeout: Span = None) -> bool:
        """Return whether `lookup_transform` would succeed, now or within ``timeout`` seconds.

        Raises:
            NodeShutdownError: the node shut down during the wait.
        """
        time_ns = _to_nanoseconds(time)
        return (
            self._wait_until_possible(
                lambda: self._tree.transform_problem(target_frame, source_frame, time_ns), timeout
            )
            is None
        )

    def can_transform_full(
        self,
        target_frame: str,
        target_time: When,
        source_frame: str,
        source_time: When,
        fixed_frame: str,
        timeout: Span = None,
    ) -> bool:
        """Return whether `lookup_transform_full` would succeed, now or within ``timeout`` seconds."""
        arguments = (
            target_frame,
            _to_nanoseconds(target_time),
            source_frame,
            _to_nanoseconds(source_time),
            fixed_frame,
        )
        return self._wait_until_possible(lambda: self._tree.transform_problem_full(*arguments), timeout) is None

    def why_not(self, target_frame: str, source_frame: str, time: When = None) -> str | None:
        """Return the reason why `lookup_transform` would fail now, in tf2's words, possibly an empty string; None if it
        would succeed.
        """
        with self._lock:
            return self._tree.transform_problem(target_frame, source_frame, _to_nanoseconds(time))

    def why_not_full(
        self, target_frame: str, target_time: When, source_frame: str, source_time: When, fixed_frame: str
    ) -> str | None:
        """Return the reason why `lookup_transform_full` would fail now, or None; see `why_not`."""
        arguments = (
            target_frame,
            _to_nanoseconds(target_time),
            source_frame,
            _to_nanoseconds(source_time),
            fixed_frame,
        )
        with self._changed:
            return self._tree.transform_problem_full(*arguments)

    def get_latest_common_time(self, target_frame: str, source_frame: str) -> Any:
        """Return the latest time at which all transforms between the two frames are known, or 0 if all of them are
        static.

        Raises:
            LookupException: a frame does not exist.
            ConnectivityException: the frames are not connected.
        """
        with self._changed:
            stamp = self._tree.latest_common_time(target_frame, source_frame)
        return self._time_class(stamp // _NS_PER_S, stamp % _NS_PER_S)

    def chain(
        self, target_frame: str, source_frame: str, time: When = None, fixed_frame: str | None = None
    ) -> list[str]:
        """Return the names of the frames on the path from source (through ``fixed_frame``) to target, both included.

        Raises the same errors as `lookup_transform`."""
        return self.chain_full(target_frame, time, source_frame, time, fixed_frame or source_frame)

    def chain_full(
        self, target_frame: str, target_time: When, source_frame: str, source_time: When, fixed_frame: str
    ) -> list[str]:
        """Return the names of the frames on the path from ``source_frame`` at ``source_time``, through ``fixed_frame``,
        to ``target_frame`` at ``target_time``.

        Raises the same errors as `lookup_transform`."""
        arguments = (
            target_frame,
            _to_nanoseconds(target_time),
            source_frame,
            _to_nanoseconds(source_time),
            fixed_frame,
        )
        with self._changed:
            return self._tree.chain(*arguments)

    def frames(self) -> list[str]:
        """Return the names of all frames, in the order in which they were added."""
        with self._changed:
            return list(self._tree.frames)

    def states(self) -> list[FrameState]:
        """Return the state of each frame, in the order in which they were added."""
        with self._changed:
            return [
                FrameState(
                    frame.name,
                    frame.parent.name if frame.parent else None,
                    frame.authority,
                    bool(frame.static),
                    frame.frequency,
                    to_sec(frame.latest),
                    to_sec(frame.oldest),
                    len(frame),
                )
                for frame in self._tree.frames.values()
            ]

    def has_frame(self, name: str) -> bool:
        """Return whether there is a frame with that name."""
        return name in self._tree.frames

    def all_frames_as_yaml(self, now: float | None = None) -> str:
        """Return parent, broadcaster, rate and times of each frame as YAML; with ``now`` in seconds, also the age of
        its newest transform.
        """
        with self._changed:
            return as_yaml(self._tree.frames.values(), now)

    def all_frames_as_string(self) -> str:
        """Return a string with one line per frame."""
        with self._changed:
            return as_string(self._tree.frames.values())

    def all_frames_as_dot(self, now: float | None = None) -> str:
        """Return the tree as a graph in Graphviz's dot language; with ``now`` in seconds, also the age of each frame's
        newest transform, and a legend.
        """
        with self._changed:
            return as_dot(self._tree.frames.values(), now)

    def _make_message(self, target: str, source: str, stamp: int, transform: Transform) -> Any:
        # The constructors are bypassed, since they would take as long as the lookup.
        message = _new_object(self._transform_stamped_class)
        message.header = header = _new_object(self._header_class)
        header.seq, header.stamp, header.frame_id = 0, self._time_class(stamp // _NS_PER_S, stamp % _NS_PER_S), target
        message.child_frame_id = source
        message.transform = pose = _new_object(self._transform_class)
        pose.translation = v = _new_object(self._vector_class)
        pose.rotation = q = _new_object(self._quaternion_class)
        v.x, v.y, v.z, q.x, q.y, q.z, q.w = transform
        return message

    # Waiting ----------------------------------------------------------------------------------------------------------

    def use_time(self, now: Callable[[], float]) -> None:
        """Measure timeouts with ``now``, which returns the time in seconds; the caller must call `wake` whenever that
        time changes.
        """
        self._clock = now

    def wake(self) -> None:
        """Make waiting lookups check the time again."""
        with self._changed:
            self._changed.notify_all()

    def end_waits(self) -> None:
        """End all current and future waits with NodeShutdownError, since no more transforms will arrive."""
        with self._changed:
            self._waits_ended = True
            self._changed.notify_all()

    def _retry_until(self, lookup: Callable[[], _T], timeout: Span) -> _T:
        """Repeat a lookup until it succeeds, and return its result; at the timeout, raise its last error."""
        with self._changed:
            started_at: float | None = None
            while True:
                try:
                    return lookup()
                except _RETRYABLE_ERRORS:
                    if not timeout:
                        raise
                    if started_at is None:
                        started_at = self._clock()
                    if not self._wait(started_at, _to_seconds(timeout)):
                        raise

    def _wait_until_possible(self, find_problem: Callable[[], str | None], timeout: Span) -> str | None:
        with self._changed:
            started_at, seconds = self._clock(), _to_seconds(timeout)
            while (problem := find_problem()) is not None and timeout and self._wait(started_at, seconds):
                pass
            return problem

    def _wait(self, started_at: float, timeout: float) -> bool:
        """Wait for a change; return False if the timeout is over, or if simulated time has jumped back, as when a bag
        starts again. The caller must hold the lock.

        Raises:
            NodeShutdownError: the node has shut down.
        """
        if self._waits_ended:
            raise NodeShutdownError("the wait for a transform was interrupted because the node has shut down")
        now = self._clock()
        remaining = started_at + timeout - now
        if remaining <= 0 or now < started_at:
            return False
        self._num_waiting += 1
        try:
            self._changed.wait(remaining if self._clock is monotonic else None)
        finally:
            self._num_waiting -= 1
        return True


def _to_nanoseconds(time: When) -> int:
    if not time:
        return 0
    if isinstance(time, (int, float)):
        time = Time.from_sec(time)
    elif not hasattr(time, "secs"):
        raise TypeError(f"time must be a Time or a number of seconds, not {time!r:.80}")
    return int(time.secs * _NS_PER_S + time.nsecs)


def _to_seconds(span: Span) -> float:
    if not span:
        return 0.0
    if not isinstance(span, (int, float)) and not hasattr(span, "to_sec"):
        raise TypeError(f"a timeout or time span must be a Duration or a number of seconds, not {span!r:.80}")
    return float(span if isinstance(span, (int, float)) else span.to_sec())
