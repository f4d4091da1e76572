"""The tree of all frames, with tf2's rules for lookups. Does no I/O and uses no locks; times are in nanoseconds."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import isnan

from pyros1.tf.errors import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TransformException,
)
from pyros1.tf.fast_decoder import Row
from pyros1.tf.frame import Entry, Frame, to_sec
from pyros1.tf.rotation import IDENTITY, Transform, invert, multiply, multiply_normalized, product
from pyros1.tf.tree_formats import as_string

_MAX_DEPTH = 1000
"""Maximum number of frames on a path; a longer one must be a loop."""

_TOLERANCE = 10e-3
"""Maximum deviation of a quaternion's squared length from 1."""


class Tree:
    """The tree of frames, by name.

    Args:
        max_age: maximum age of transforms in nanoseconds, relative to the frame's newest one; older ones are dropped.
    """

    def __init__(self, max_age: int) -> None:
        self.max_age = max_age
        self.frames: dict[str, Frame] = {}
        self._has_double_slash_names = False  # whether a frame was named with two leading slashes; one is removed

    # Filling ----------------------------------------------------------------------------------------------------------

    def insert_rows(self, rows: Iterable[Row], static: bool, authority: str) -> list[str]:
        """Add several transforms.

        Returns:
            The reasons why transforms were ignored, in tf2's words.
        """
        problems: list[str] = []
        frames, max_age = self.frames, self.max_age
        for parent, child, time, transform in rows:
            frame = frames.get(child)
            parent_frame = frames.get(parent)
            if frame is not None and parent_frame is not None and frame is not parent_frame and frame.static is False:
                # The usual case, inlined for speed: the frames are known, and the transform is the newest one.
                x, y, z, qx, qy, qz, qw = transform
                squared_length = qx * qx + qy * qy + qz * qz + qw * qw
                stamps = frame.stamps
                if (
                    -_TOLERANCE < squared_length - 1.0 < _TOLERANCE
                    and not isnan(x + y + z)
                    and stamps
                    and time > stamps[-1]
                    and not self._has_double_slash_names
                ):
                    frame.append(time, (parent_frame, transform, squared_length), time - max_age)
                    frame.authority = authority
                    continue
            problems += self.insert(parent, child, time, transform, static, authority)
        return problems

    def insert(
        self, parent: str, child: str, time: int, transform: Transform, static: bool, authority: str
    ) -> list[str]:
        """Add a transform.

        Returns:
            The reasons why it was ignored, in tf2's words; empty if it was added.
        """
        frames = self.frames
        frame = frames.get(child)
        parent_frame = frames.get(parent)
        if frame is None or parent_frame is None or frame is parent_frame or self._has_double_slash_names:
            if parent[:1] == "/":
                parent = parent[1:]
            if child[:1] == "/":
                child = child[1:]
            problems = _find_problems(parent, child, transform, authority)
            if problems:
                return problems
            frame, parent_frame = self._get_or_add(child), self._get_or_add(parent)
        x, y, z, qx, qy, qz, qw = transform
        squared_length = qx * qx + qy * qy + qz * qz + qw * qw
        if isnan(x + y + z) or not -_TOLERANCE < squared_length - 1.0 < _TOLERANCE:
            problems = _find_problems(parent, child, transform, authority)
            if problems:
                return problems
        if frame.static is None:
            frame.static = static
        problem = frame.insert(time, (parent_frame, transform, squared_length), self.max_age)
        if problem is None:
            frame.authority = authority
            return []
        return [f"{problem} for frame {child} at time {to_sec(time):.6f} according to authority {authority}"]

    def _get_or_add(self, name: str) -> Frame:
        frame = self.frames.get(name)
        if frame is None:
            frame = self.frames[name] = Frame(name)
            self._has_double_slash_names = self._has_double_slash_names or name[0] == "/"
        return frame

    def clear(self) -> None:
        """Remove all transforms except for static ones. The frames remain."""
        for frame in self.frames.values():
            frame.clear()

    # Lookups ----------------------------------------------------------------------------------------------------------

    def lookup(self, target: str, source: str, time: int) -> tuple[int, Transform]:
        """Return the stamp and the transform of ``source`` in ``target``; time 0 means the latest time at which all
        transforms between them are known.

        Raises:
            TransformException: see `pyros1.tf.errors`.
        """
        if target == source:
            frame = self.frames.get(target)
            return (frame.latest if frame is not None and not time else time), IDENTITY
        target_frame = self._find_frame("lookupTransform argument target_frame", target)
        return self._find_transform(
            target_frame, self._find_frame("lookupTransform argument source_frame", source), time
        )

    def lookup_full(
        self, target: str, target_time: int, source: str, source_time: int, fixed: str
    ) -> tuple[int, Transform]:
        """Return the stamp and the transform of ``source`` at one time in ``target`` at another, if ``fixed`` does not
        move.

        Raises:
            TransformException: see `pyros1.tf.errors`.
        """
        self._find_frame("lookupTransform argument target_frame", target)
        self._find_frame("lookupTransform argument source_frame", source)
        self._find_frame("lookupTransform argument fixed_frame", fixed)
        _, source_to_fixed = self.lookup(fixed, source, source_time)
        stamp, fixed_to_target = self.lookup(target, fixed, target_time)
        return stamp, multiply_normalized(fixed_to_target, source_to_fixed)

    def latest_common_time(self, target: str, source: str) -> int:
        """Return the latest time at which all transforms between two frames are known, or 0 if all are static.

        Raises:
            LookupException: a frame does not exist, or there is a loop.
            ConnectivityException: the frames are not connected.
        """
        target_frame = self._find_frame("get_latest_common_time", target)
        return self._common_time(target_frame, self._find_frame("get_latest_common_time", source))

    def chain(self, target: str, target_time: int, source: str, source_time: int, fixed: str) -> list[str]:
        """Return the names of the frames on the path from source through ``fixed`` to target, both included.

        Raises:
            TransformException: see `pyros1.tf.errors`.
        """
        target_frame = self._find_frame("chainAsVector argument target_frame", target)
        source_frame = self._find_frame("chainAsVector argument source_frame", source)
        fixed_frame = self._find_frame("chainAsVector argument fixed_frame", fixed)
        names = self._path_names(fixed_frame, source_frame, source_time)
        remaining_names = self._path_names(target_frame, fixed_frame, target_time)
        if names and remaining_names and names[-1] == remaining_names[0]:
            remaining_names = remaining_names[1:]
        return names + remaining_names

    def _find_frame(self, argument: str, name: str) -> Frame:
        frame = self.frames.get(name)
        if frame is not None and name[0] != "/":
            return frame
        problem = name_problem(argument, name)
        if problem:
            raise InvalidArgumentException(problem)
        raise LookupException(f'"{name}" passed to {argument} does not exist. ')

    def _find_transform(self, target: Frame, source: Frame, time: int) -> tuple[int, Transform]:
        """Return the stamp and the transform of ``source`` in ``target``."""
        time, source_steps, target_steps = self._find_path(target, source, time, Frame.entry_at)
        source_to_ancestor = product(source_steps) if source_steps else IDENTITY
        if not target_steps:
            return time, source_to_ancestor
        ancestor_to_target = invert(product(target_steps))
        return time, multiply(ancestor_to_target, source_to_ancestor) if source_steps else ancestor_to_target

    def _find_path(
        self, target: Frame, source: Frame, time: int, find_entry: Callable[[Frame, int], Entry | None]
    ) -> tuple[int, list[Transform], list[Transform]]:
        """Find the path between two frames, which leads up from both to their common ancestor.

        Args:
            find_entry: returns a frame's entry for a given time, or None.

        Returns:
            The time, the transforms from source up to the ancestor, and the transforms from target up to the ancestor.

        Raises:
            TransformException: see `pyros1.tf.errors`.
        """
        if target is source:
            return time, [], []
        if not time:
            time = self._common_time(target, source)
        source_steps: list[Transform] = []
        current = source
        for _ in range(_MAX_DEPTH):
            entry = find_entry(current, time)
            if entry is None:
                break
            current, transform, _square = entry
            source_steps.append(transform)
            if current is target:
                return time, source_steps, []
        else:
            raise self._loop_error()
        last_source = current
        target_steps: list[Transform] = []
        frame = target
        while frame is not current:
            entry = find_entry(frame, time)
            if entry is None:
                if frame.static is not None:
                    raise ExtrapolationException(frame.why_not(time) + _lookup_suffix(source, target))
                if last_source.static is not None:
                    raise ExtrapolationException(last_source.why_not(time) + _lookup_suffix(source, target))
                raise _unconnected_error(source, target)
            frame, transform, _ = entry
            target_steps.append(transform)
            if frame is source:
                return time, [], target_steps
            if len(target_steps) > _MAX_DEPTH:
                raise self._loop_error()
        return time, source_steps, target_steps

    def _common_time(self, target: Frame, source: Frame) -> int:
        if target is source:
            return source.latest
        times: dict[Frame, int] = {}  # ancestor of source -> newest time at which the path to it is known
        frame = source
        common_time = 0
        while entries := frame.entries:
            latest = frame.stamps[-1]
            if latest and (not common_time or latest < common_time):
                common_time = latest
            frame = entries[-1][0]
            if frame is target:
                return common_time
            if frame in times:
                raise self._loop_error()
            times[frame] = common_time
        frame = target
        common_time = 0
        num_steps = 0
        while entries := frame.entries:
            latest = frame.stamps[-1]
            if latest and (not common_time or latest < common_time):
                common_time = latest
            frame = entries[-1][0]
            if frame in times:
                source_time = times[frame]
                return min(common_time, source_time) if common_time and source_time else common_time or source_time
            if frame is source:
                return common_time
            num_steps += 1
            if num_steps > _MAX_DEPTH:
                raise self._loop_error()
        raise _unconnected_error(source, target)

    def _path_names(self, target: Frame, source: Frame, time: int) -> list[str]:
        time, _, _ = self._find_path(target, source, time, Frame.entry_before)
        source_ancestors = self._ancestors(source, time)
        target_ancestors = self._ancestors(target, time)
        while len(source_ancestors) > 1 and len(target_ancestors) > 1 and source_ancestors[-2] is target_ancestors[-2]:
            source_ancestors.pop()
            target_ancestors.pop()
        if target in source_ancestors:
            return [frame.name for frame in source_ancestors[: source_ancestors.index(target) + 1]]
        if source in target_ancestors:
            return [frame.name for frame in reversed(target_ancestors[: target_ancestors.index(source) + 1])]
        return [frame.name for frame in [*source_ancestors, *reversed(target_ancestors[:-1])]]

    @staticmethod
    def _ancestors(frame: Frame, time: int) -> list[Frame]:
        """Return the frame and its ancestors, up to the root."""
        frames = [frame]
        while (entry := frames[-1].entry_before(time)) is not None and len(frames) <= _MAX_DEPTH:
            frames.append(entry[0])
        return frames

    def transform_problem(self, target: str, source: str, time: int) -> str | None:
        """Return the reason why `lookup` would fail; None if it would succeed."""
        if target == source:
            return None
        return self._frame_problem(target_frame=target, source_frame=source) or self._path_problem(target, source, time)

    def transform_problem_full(
        self, target: str, target_time: int, source: str, source_time: int, fixed: str
    ) -> str | None:
        """Return the reason why `lookup_full` would fail; None if it would succeed."""
        return (
            self._frame_problem(target_frame=target, source_frame=source, fixed_frame=fixed)
            or self._path_problem(target, fixed, target_time)
            or self._path_problem(fixed, source, source_time)
        )

    def _frame_problem(self, **names_by_role: str) -> str:
        """Return a message about frames that have an invalid name or do not exist, or an empty string if there are
        none.
        """
        for role, name in names_by_role.items():
            problem = name_problem(f"canTransform argument {role}", name)
            if problem:
                return problem
        missing = [
            f"canTransform: {role} {name} does not exist."
            for role, name in names_by_role.items()
            if name not in self.frames
        ]
        return " ".join(missing)

    def _path_problem(self, target: str, source: str, time: int) -> str | None:
        try:
            self._find_path(self.frames[target], self.frames[source], time, Frame.entry_before)
        except TransformException as error:
            return str(error)
        return None

    def _loop_error(self) -> LookupException:
        return LookupException(
            f"The tf tree is invalid because it contains a loop.\n{as_string(self.frames.values())}\n"
        )


def name_problem(argument: str, name: str) -> str:
    """Return the problem with a frame's name in a lookup, in tf2's words, or an empty string if it is valid.

    Raises:
        TypeError: the name is not a str.
    """
    if not isinstance(name, str):
        raise TypeError(f"{argument} must be the name of a frame, not {name!r:.80}")
    if not name:
        return f"Invalid argument passed to {argument} in tf2 frame_ids cannot be empty"
    if name[0] == "/":
        return f"Invalid argument \"{name}\" passed to {argument} in tf2 frame_ids cannot start with a '/' like: "
    return ""


def _lookup_suffix(source: Frame, target: Frame) -> str:
    return f", when looking up transform from frame [{source.name}] to frame [{target.name}]"


def _unconnected_error(source: Frame, target: Frame) -> ConnectivityException:
    return ConnectivityException(
        f"Could not find a connection between '{target.name}' and '{source.name}' because they are not part of the "
        f"same tree.Tf has two or more unconnected trees."
    )


def _find_problems(parent: str, child: str, transform: Transform, authority: str) -> list[str]:
    """Return the reasons why a transform cannot be used, if any."""
    problems = []
    if child == parent:
        problems.append(
            f'TF_SELF_TRANSFORM: Ignoring transform from authority "{authority}" with frame_id and child_frame_id  '
            f'"{child}" because they are the same'
        )
    if not child:
        problems.append(
            f'TF_NO_CHILD_FRAME_ID: Ignoring transform from authority "{authority}" because child_frame_id not set '
        )
    if not parent:
        problems.append(
            f'TF_NO_FRAME_ID: Ignoring transform with child_frame_id "{child}"  from authority "{authority}" because '
            f"frame_id not set"
        )
    numbers = [f"{part:.6f}" for part in transform]
    rotation = " ".join(numbers[3:])
    if any(map(isnan, transform)):
        problems.append(
            f'TF_NAN_INPUT: Ignoring transform for child_frame_id "{child}" from authority "{authority}" because of a '
            f"nan value in the transform ({' '.join(numbers[:3])}) ({rotation})"
        )
    x, y, z, w = transform[3:]
    if not abs(w * w + x * x + y * y + z * z - 1.0) < _TOLERANCE:
        problems.append(
            f'TF_DENORMALIZED_QUATERNION: Ignoring transform for child_frame_id "{child}" from authority "{authority}" '
            f"because of an invalid quaternion in the transform ({rotation})"
        )
    return problems
