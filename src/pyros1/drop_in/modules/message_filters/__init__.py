"""Message filters that can be chained, like stock's Python module (https://wiki.ros.org/message_filters)."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any

import rospy

from pyros1.filters.synchronizers import ApproximateTime, ExactTime

_NO_HEADER = (
    "Cannot use message filters with non-stamped messages. "
    "Use the 'allow_headerless' constructor option to auto-assign ROS time to headerless messages."
)


class SimpleFilter:
    """Base class of all filters.

    Attributes:
        callbacks: number -> (function, further arguments).
    """

    def __init__(self) -> None:
        self.callbacks: dict[int, tuple[Callable[..., object], tuple[Any, ...]]] = {}

    def registerCallback(self, cb: Callable[..., object], *args: Any) -> int:
        """Call a function with the output of the filter, followed by ``args``; return the number of the callback."""
        number = len(self.callbacks)
        self.callbacks[number] = (cb, args)
        return number

    def signalMessage(self, *msg: Any) -> None:
        """Pass messages to the callbacks."""
        for callback, extra_args in list(self.callbacks.values()):
            callback(*msg, *extra_args)


class Subscriber(SimpleFilter):
    """A filter that outputs the messages on a topic.

    Args:
        args, kwargs: the arguments of `rospy.Subscriber`; this object also has its attributes.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__()
        self.topic = args[0]
        self.sub = rospy.Subscriber(*args, **{**kwargs, "callback": self.callback})

    def callback(self, msg: Any) -> None:
        """Pass a message to the callbacks."""
        self.signalMessage(msg)

    def getTopic(self) -> str:
        """Return the topic's name, unresolved."""
        return self.topic

    def __getattr__(self, key: str) -> Any:
        if key == "sub":  # not yet set by the constructor
            raise AttributeError(key)
        return getattr(self.sub, key)


def _stamp(message: Any, allow_headerless: bool) -> Any:
    """Return the stamp of a message; None, with a warning, if it has none and headerless messages are not allowed."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    if stamp is None and not allow_headerless:
        rospy.logwarn(_NO_HEADER)
    return rospy.Time.now() if stamp is None and allow_headerless else stamp


class Cache(SimpleFilter):
    """Stores the newest messages of a filter in the order of their arrival, and passes them on.

    Like stock's and unlike `pyros1.filters.Cache`, it does not sort by stamp.

    Args:
        f: the filter.
        cache_size: maximum number of messages.
        allow_headerless: whether to use the time of arrival as the stamp of messages without a header.
    """

    def __init__(self, f: SimpleFilter, cache_size: int = 1, allow_headerless: bool = False) -> None:
        super().__init__()
        self.cache_size = cache_size
        self.cache_msgs: list[Any] = []
        self.cache_times: list[Any] = []
        self.allow_headerless = allow_headerless
        self.connectInput(f)

    def connectInput(self, f: SimpleFilter) -> None:
        """Connect to a filter."""
        self.incoming_connection = f.registerCallback(self.add)

    def add(self, msg: Any) -> None:
        """Store a message, and pass it on."""
        stamp = _stamp(msg, self.allow_headerless)
        if stamp is None:
            return
        self.cache_times.append(stamp)
        self.cache_msgs.append(msg)
        if len(self.cache_msgs) > self.cache_size:
            del self.cache_msgs[0], self.cache_times[0]
        self.signalMessage(msg)

    def _select(self, condition: Callable[[Any], bool]) -> list[Any]:
        return [msg for msg, stamp in zip(self.cache_msgs, self.cache_times, strict=False) if condition(stamp)]

    def getInterval(self, from_stamp: Any, to_stamp: Any) -> list[Any]:
        """Return the messages with stamps in a closed interval."""
        if from_stamp > to_stamp:
            raise AssertionError
        return self._select(lambda stamp: from_stamp <= stamp <= to_stamp)

    def getElemAfterTime(self, stamp: Any) -> Any:
        """Return the first message with this or a later stamp; None if there is none."""
        return next(iter(self._select(lambda other_stamp: other_stamp >= stamp)), None)

    def getElemBeforeTime(self, stamp: Any) -> Any:
        """Return the last message with this or an earlier stamp; None if there is none."""
        return next(reversed(self._select(lambda other_stamp: other_stamp <= stamp)), None)

    def getLatestTime(self) -> Any:
        """Return the stamp of the last message; None if there is none."""
        return self.cache_times[-1] if self.cache_times else None

    def getLastestTime(self) -> Any:
        """Return the stamp of the last message; the old name of `getLatestTime`."""
        return self.getLatestTime()

    def getOldestTime(self) -> Any:
        """Return the stamp of the first message; None if there is none."""
        return self.cache_times[0] if self.cache_times else None

    def getLast(self) -> Any:
        """Return the last message; None if there is none."""
        latest = self.getLatestTime()
        return None if latest is None else self.getElemAfterTime(latest)


class TimeSynchronizer(SimpleFilter):
    """Outputs sets of messages with the same stamp, one from each of several filters.

    Args:
        fs: the filters.
        queue_size: maximum number of messages from each filter that wait for messages from the others.
        reset: whether to drop the messages of a filter when simulated time jumps back.

    Attributes:
        queues: for each filter, stamp -> message.
        latest_stamps: with ``reset``, the time at which each filter's last message arrived.
    """

    def __init__(self, fs: Sequence[SimpleFilter], queue_size: int, reset: bool = False) -> None:
        super().__init__()
        self.queue_size = queue_size
        self.lock = threading.RLock()
        self.enable_reset = reset
        self.connectInput(fs)

    def _make_synchronizer(self, count: int) -> ExactTime:
        return ExactTime(count, self.queue_size)

    def connectInput(self, fs: Sequence[SimpleFilter]) -> None:
        """Connect to filters, with empty queues."""
        self._synchronizer = self._make_synchronizer(len(fs))
        self.queues = self._synchronizer.queues
        self.latest_stamps = [rospy.Time(0) for _ in fs]
        self.input_connections = [
            f.registerCallback(self.add, queue, index)
            for index, (f, queue) in enumerate(zip(fs, self.queues, strict=True))
        ]

    def add(self, msg: Any, my_queue: dict[Any, Any], my_queue_index: int | None = None) -> None:
        """Add a message.

        Args:
            msg: the message.
            my_queue: the queue of its filter, one of ``queues``.
            my_queue_index: the index of that queue.
        """
        self._add(msg.header.stamp, msg, my_queue, my_queue_index)

    def _add(self, stamp: Any, msg: Any, queue: dict[Any, Any], given_index: int | None) -> None:
        index = (
            given_index
            if given_index is not None
            else next(i for i, candidate in enumerate(self.queues) if candidate is queue)
        )
        with self.lock:
            now = rospy.Time.now()
            may_match = self._record_arrival(now, queue, given_index)
            self._synchronizer.queue_size = self.queue_size  # programs may change it
            self._synchronizer.keep(index, stamp, msg)
            self._check_time_jump(now)
            if may_match:
                for messages in self._synchronizer.complete(index, stamp):
                    self.signalMessage(*messages)

    def _record_arrival(self, now: Any, queue: dict[Any, Any], index: int | None) -> bool:
        """Record when a message arrived.

        Return False if sets must not be matched yet, since other queues may contain messages from before a time jump.
        """
        if not self.enable_reset or rospy.rostime.is_wallclock():
            return True
        if index is not None:
            if now < self.latest_stamps[index]:
                rospy.logdebug("Detected jump back in time. Clearing message filter queue")
                queue.clear()
            self.latest_stamps[index] = now
        return bool(max(self.latest_stamps) == now)

    def _check_time_jump(self, now: Any) -> None:
        """Handle a backward jump of the clock."""


class ApproximateTimeSynchronizer(TimeSynchronizer):
    """Outputs sets of messages whose stamps differ by less than ``slop``, one from each of several filters.

    Args:
        fs, queue_size, reset: see `TimeSynchronizer`.
        slop: maximum difference in seconds.
        allow_headerless: whether to use the time of arrival as the stamp of messages without a header.
    """

    def __init__(
        self,
        fs: Sequence[SimpleFilter],
        queue_size: int,
        slop: float,
        allow_headerless: bool = False,
        reset: bool = False,
    ) -> None:
        self.slop = rospy.Duration.from_sec(slop)
        self.allow_headerless = allow_headerless
        self.last_added = rospy.Time()
        super().__init__(fs, queue_size, reset)

    def _make_synchronizer(self, count: int) -> ExactTime:
        return ApproximateTime(count, self.queue_size, self.slop.to_sec())

    def add(self, msg: Any, my_queue: dict[Any, Any], my_queue_index: int | None = None) -> None:
        """Add a message; see `TimeSynchronizer.add`."""
        stamp = _stamp(msg, self.allow_headerless)
        if stamp is not None:
            self._add(stamp, msg, my_queue, my_queue_index)

    def _check_time_jump(self, now: Any) -> None:
        if now < self.last_added:
            rospy.loginfo("ApproximateTimeSynchronizer: Detected jump back in time. Clearing buffer.")
            for queue in self.queues:
                queue.clear()
        self.last_added = now
