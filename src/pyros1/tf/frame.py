"""A frame, with its transforms into its parent over time."""

from __future__ import annotations

from bisect import bisect_right
from math import acos, sin, sqrt

from pyros1.tf.rotation import Transform

_MAX_OUTDATED_ITEMS = 512
"""Number of outdated transforms above which all of them are removed from the lists at once."""

Entry = tuple["Frame", Transform, float]
"""(parent of the frame, transform from the frame into the parent, square of the quaternion's length)."""


class Frame:
    """A frame and its recent transforms. Times are in nanoseconds.

    Attributes:
        name: name without a leading slash.
        static: whether its transform is valid at all times; None while the frame is only known as a parent. As in tf2,
            this is determined by the first transform.
        authority: name of the node that sent the last transform.
        stamps, entries: times and transforms, oldest first; items before the index `_oldest_index` are outdated.
    """

    __slots__ = ("_cached_entry", "_cached_time", "_oldest_index", "authority", "entries", "name", "stamps", "static")

    def __init__(self, name: str) -> None:
        self.name = name
        self.static: bool | None = None
        self.authority = "no recorded authority"
        self.stamps: list[int] = []
        self.entries: list[Entry] = []
        self._oldest_index = 0  # index of the oldest current item; earlier items are removed in batches
        # Time and result of the last interpolation: programs often look up the same time again, for several frames or
        # after can_transform.
        self._cached_time: int | None = None
        self._cached_entry: Entry | None = None

    def insert(self, time: int, entry: Entry, max_age: int) -> str | None:
        """Add a transform.

        Args:
            time: the transform's stamp.
            entry: the transform, with its parent.
            max_age: maximum age of transforms in nanoseconds, relative to the newest one; older ones are dropped.

        Returns:
            None, or the reason why it was not added, in tf2's words.
        """
        if self.static:
            self.stamps = [0]
            self.entries = [entry]
            return None
        stamps = self.stamps
        if not stamps or time > stamps[-1]:
            self.append(time, entry, time - max_age)
            return None
        self._cached_time = None
        if stamps[-1] > time + max_age:
            return (
                "TF_OLD_DATA ignoring data from the past (Possible reasons are listed at "
                "http://wiki.ros.org/tf/Errors%20explained)"
            )
        index = bisect_right(stamps, time, self._oldest_index)
        if index > self._oldest_index and stamps[index - 1] == time:
            return "TF_REPEATED_DATA ignoring data with redundant timestamp"
        stamps.insert(index, time)
        self.entries.insert(index, entry)
        return None

    def append(self, time: int, entry: Entry, oldest: int) -> None:
        """Add a transform that is newer than all others, and drop transforms from before the time ``oldest``."""
        self._cached_time = None
        stamps = self.stamps
        stamps.append(time)
        self.entries.append(entry)
        oldest_index = self._oldest_index
        if stamps[oldest_index] < oldest:
            while stamps[oldest_index] < oldest:
                oldest_index += 1
            if oldest_index > _MAX_OUTDATED_ITEMS:
                del stamps[:oldest_index], self.entries[:oldest_index]
                oldest_index = 0
            self._oldest_index = oldest_index

    def entry_at(self, time: int) -> Entry | None:  # noqa: PLR0911 - called for each frame of each lookup, so it must be fast
        """Return the entry at a time (0 for the newest), or None if there is none; `why_not` then returns the reason.

        Between two transforms, the position is interpolated linearly, and the rotation along the shortest arc (slerp).
        """
        entries = self.entries
        if self.static or (not time and entries):
            return entries[-1]
        if time == self._cached_time:
            return self._cached_entry
        stamps = self.stamps
        if not stamps or time >= stamps[-1]:
            return entries[-1] if stamps and time == stamps[-1] else None
        index = bisect_right(stamps, time, self._oldest_index) - 1
        if index < self._oldest_index:
            return None
        older_stamp = stamps[index]
        older = entries[index]
        if older_stamp == time:
            return older
        parent, (x, y, z, ax, ay, az, aw), square = older
        newer_parent, (x2, y2, z2, bx, by, bz, bw), square2 = entries[index + 1]
        if newer_parent is not parent:
            return older  # the frame changed its parent between the two
        fraction = (time - older_stamp) / (stamps[index + 1] - older_stamp)
        remainder = 1.0 - fraction
        x = remainder * x + fraction * x2
        y = remainder * y + fraction * y2
        z = remainder * z + fraction * z2
        dot = ax * bx + ay * by + az * bz + aw * bw
        cosine = (dot if dot > 0.0 else -dot) / sqrt(square * square2)  # faster than calling min and abs
        theta = acos(cosine) if cosine < 1.0 else 0.0
        if theta:
            scale = 1.0 / sin(theta)
            s = sin(remainder * theta)
            t = sin(fraction * theta)
            if dot < 0.0:
                t = -t  # q and -q are the same rotation; the nearer quaternion is used
            transform = (
                x,
                y,
                z,
                (ax * s + bx * t) * scale,
                (ay * s + by * t) * scale,
                (az * s + bz * t) * scale,
                (aw * s + bw * t) * scale,
            )
        else:
            transform = x, y, z, ax, ay, az, aw
        self._cached_time = time
        self._cached_entry = result = parent, transform, 1.0  # not used for further interpolation
        return result

    def entry_before(self, time: int) -> Entry | None:
        """Return the last entry at or before a time: the same as `entry_at`, but without interpolation."""
        entries = self.entries
        if self.static or (not time and entries):
            return entries[-1]
        stamps = self.stamps
        if not stamps or time >= stamps[-1]:
            return entries[-1] if stamps and time == stamps[-1] else None
        index = bisect_right(stamps, time, self._oldest_index) - 1
        return entries[index] if index >= self._oldest_index else None

    def why_not(self, time: int) -> str:
        """Return the reason why there is no transform at a time, in tf2's words."""
        if not self.stamps:
            return ""
        earliest, latest = self.oldest, self.latest
        if len(self) == 1:
            return (
                f"Lookup would require extrapolation at time {_format_seconds(time)}, "
                f"but only time {_format_seconds(latest)} is in the buffer"
            )
        if time > latest:
            return (
                f"Lookup would require extrapolation {_format_seconds(time - latest)}s into the future.  "
                f"Requested time {_format_seconds(time)} but the latest data is at time {_format_seconds(latest)}"
            )
        return (
            f"Lookup would require extrapolation {_format_seconds(earliest - time)}s into the past.  "
            f"Requested time {_format_seconds(time)} but the earliest data is at time {_format_seconds(earliest)}"
        )

    def clear(self) -> None:
        """Remove all transforms except for static ones."""
        if not self.static:
            self.stamps = []
            self.entries = []
            self._oldest_index = 0
            self._cached_time = None

    @property
    def latest(self) -> int:
        """Stamp of the newest transform; 0 if there is none, or if it is static."""
        return self.stamps[-1] if self.stamps else 0

    @property
    def oldest(self) -> int:
        """Stamp of the oldest transform; 0 if there is none, or if it is static."""
        return self.stamps[self._oldest_index] if self.stamps else 0

    @property
    def parent(self) -> Frame | None:
        """The parent in the newest transform; None if there are no transforms."""
        return self.entries[-1][0] if self.entries else None

    def __len__(self) -> int:
        return len(self.stamps) - self._oldest_index

    def __bool__(self) -> bool:
        return True

    @property
    def frequency(self) -> float:
        """Rate of the transforms in Hz; 0 if there are fewer than two."""
        return (len(self) - 1) / (to_sec(self.latest) - to_sec(self.oldest)) if len(self) > 1 else 0.0

    @property
    def tf2_rate(self) -> float:
        """The rate in Hz as tf2 computes it: one transform too many is counted, and a single one has a rate of
        10000.
        """
        return len(self) / max(to_sec(self.latest) - to_sec(self.oldest), 0.0001)


def to_sec(time: int) -> float:
    """Convert nanoseconds to seconds with roscpp's rounding, so that printed times equal tf2's to the last digit."""
    return time // 1_000_000_000 + 1e-9 * (time % 1_000_000_000)


def _format_seconds(time: int) -> str:
    return f"{time // 1_000_000_000}.{time % 1_000_000_000:09d}"
