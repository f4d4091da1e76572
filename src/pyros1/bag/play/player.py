"""Plays bags: publishes their messages, as stored, at the pace of the recording.

The thread that calls `Player.run` sleeps until the next message or tick of /clock is due, or the user gives a command.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from math import inf
from time import perf_counter
from typing import Any

from pyros1.bag.format.records import MAX_TIME, Connection
from pyros1.bag.play.clock import NS_PER_S, Ticker, Timeline
from pyros1.bag.play.control import Control
from pyros1.bag.play.read_ahead import BagSet, PlayItem, ReadAhead
from pyros1.bag.play.static import StaticTransforms, is_static_transforms
from pyros1.ground.errors import Error
from pyros1.ground.timing import Time
from pyros1.msgs import AnyMsg, load_message
from pyros1.node import Node
from pyros1.wire.handshake import TopicType

_STATUS_PERIOD = 0.1
_POLL_PERIOD = 0.05
_DRAIN_TIMEOUT = 5.0
_NODE_TOPIC_TYPES = ("rosgraph_msgs/Log", "rosgraph_msgs/Clock")
"""Types of the topics that the node publishes itself; its publishers on these topics accept encoded messages, too."""


@dataclass(frozen=True)
class PlayOptions:
    """Playback options.

    Attributes:
        prefix: text to put before all topics.
        immediate: whether to play without waiting between messages.
        queue_size: queue size of the publishers.
        clock_rate: number of messages on /clock per second of wall time; 0 for none.
        rate: speed factor.
        start: seconds to skip at the beginning.
        duration: seconds to play; None for the whole bag.
        skip_empty: gaps between messages that are longer than this, in seconds of bag time, are skipped; None skips
        none.
        loop: whether to start again at the end.
        pause_topics: topics before whose messages playback pauses.
        max_delay: seconds by which `Player.rate_stamp` may lag behind the bag time before playback waits.
    """

    prefix: str = ""
    immediate: bool = False
    queue_size: int = 100
    clock_rate: float = 0.0
    rate: float = 1.0
    start: float = 0.0
    duration: float | None = None
    skip_empty: float | None = None
    loop: bool = False
    pause_topics: Collection[str] = ()
    max_delay: float = inf


@dataclass(frozen=True)
class Status:
    """Playback status.

    Attributes:
        state: RUNNING, PAUSED or DELAYED.
        time: bag time, in seconds since the epoch.
        elapsed: seconds of bag time since the beginning of the bag.
        length: length of the bag in seconds.
    """

    state: str
    time: float
    elapsed: float
    length: float


class Player:
    """Plays bags.

    Args:
        node: the node that publishes.
        bags: the bags to play.
        options: the playback options.
        control: the user's commands.
        on_status: called with the status ten times a second; None for no calls.

    Attributes:
        rate_stamp: the newest stamp on the topic that controls the pace, in nanoseconds; None without such a topic.
        unplayable: topics that could not be advertised -> reason.
    """

    def __init__(
        self,
        node: Node,
        bags: BagSet,
        options: PlayOptions,
        control: Control,
        on_status: Callable[[Status], object] | None = None,
    ) -> None:
        self.rate_stamp: int | None = None
        self.unplayable: dict[str, str] = {}
        self._bags = bags
        self._options = options
        self._control = control
        self._on_status = on_status
        self._timeline = Timeline(options.rate)
        self._status_ticker = Ticker(_STATUS_PERIOD)
        self._clock_ticker = Ticker(1 / options.clock_rate if options.clock_rate else inf)
        self._node = node
        self._send_functions: dict[tuple[int, int], Callable[[AnyMsg], object]] = {}
        self._publishers: dict[tuple[str, str], Any] = {}
        self._static_transforms: dict[str, StaticTransforms] = {}
        self._pause_topics: set[str] = {topic.lstrip("/") for topic in options.pause_topics}
        self._clock_class: Any = load_message("rosgraph_msgs/Clock")
        self._clock: Any = node.advertise("clock", self._clock_class, queue_size=1)
        self._start, self._length = bags.start, bags.end - bags.start
        self._latched_messages: list[PlayItem] = []
        self._read_ahead: ReadAhead | None = None
        self._last_time: int | None = None
        for bag_index, connection in bags.connections():
            self._advertise(bag_index, connection)

    # Publishers -------------------------------------------------------------------------------------------------------

    def _advertise(self, bag_index: int, connection: Connection) -> None:
        topic, is_static = self._options.prefix + connection.topic, is_static_transforms(connection)
        key = (connection.callerid, topic)
        publisher = self._publishers.get(key)
        if publisher is None:
            topic_type = TopicType(connection.type, connection.md5sum, connection.definition)
            message_class: Any = load_message(connection.type) if connection.type in _NODE_TOPIC_TYPES else AnyMsg
            latch = connection.latching or is_static
            try:
                publisher = self._node.advertise(
                    topic, message_class, queue_size=self._options.queue_size, latch=latch, raw_type=topic_type
                )
            except Error as error:
                self.unplayable[connection.topic] = str(error)
                return
            self._publishers[key] = publisher
        send = publisher.publish
        if is_static:
            send = self._static_transforms.setdefault(publisher.name, StaticTransforms(send)).publish
        self._send_functions[bag_index, connection.id] = send

    def wait_for_subscribers(self) -> None:
        """Wait until every topic has a subscriber, or the user ends playback."""
        while not self._control.end_requested and not all(
            publisher.num_connections for publisher in self._publishers.values()
        ):
            self._control.wait(_POLL_PERIOD)

    def now(self) -> int:
        """Return the bag time in nanoseconds."""
        return self._timeline.bag_time_at(perf_counter())

    def set_rate_stamp(self, stamp: int) -> None:
        """Set the newest stamp, in nanoseconds, on the topic that controls the pace. Thread-safe."""
        self.rate_stamp = stamp
        self._control.wake()

    def dropped(self) -> int:
        """Return the number of messages that connected subscribers lost because they were too slow."""
        return sum({publisher.name: publisher.dropped for publisher in self._publishers.values()}.values())

    def wait_until_sent(self) -> bool:
        """Wait until slow subscribers have received all their messages; give up when none receives anything for 5 s.

        Returns:
            Whether all subscribers have received all messages; False if the time ran out or the user has ended
            playback.
        """
        fewest_waiting, deadline = inf, perf_counter() + _DRAIN_TIMEOUT
        while True:
            waiting = sum({publisher.name: publisher.waiting for publisher in self._publishers.values()}.values())
            if not waiting or self._control.end_requested or perf_counter() > deadline:
                return not waiting
            if waiting < fewest_waiting:
                fewest_waiting, deadline = waiting, perf_counter() + _DRAIN_TIMEOUT
            self._control.wait(_POLL_PERIOD)

    def close(self) -> None:
        """Close the publishers. Without this call, they are closed with the node."""
        for publisher in (*self._publishers.values(), self._clock):
            publisher.unregister()

    # Playing ----------------------------------------------------------------------------------------------------------

    def read_ahead(self) -> None:
        """Start reading messages, so that playback can begin without delay. `run` calls this if necessary.

        Raises:
            BagError: a chunk of a bag cannot be read.
            OSError: a file cannot be read.
        """
        if self._options.start > 0:  # before ReadAhead starts, since only one thread may read a file
            self._latched_messages = self._bags.latched_messages_before(
                self._start + int(self._options.start * NS_PER_S)
            )
        self._read_ahead = ReadAhead(self._messages())

    def _messages(self) -> Iterator[PlayItem]:
        start = self._start + int(self._options.start * NS_PER_S)
        duration = self._options.duration
        return self._bags.messages(start, MAX_TIME if duration is None else start + int(duration * NS_PER_S))

    def run(self) -> int:
        """Play to the end, or until the user ends playback.

        Returns:
            The number of messages that were played.

        Raises:
            BagError: a chunk of a bag cannot be read.
            OSError: a file cannot be read.
        """
        played = 0
        if self._read_ahead is None:
            self.read_ahead()
        try:
            while not self._control.end_requested:
                for item in self._latched_messages:
                    self._publish(item)
                count = self._play()
                played += count
                if not self._options.loop or not count:
                    break
        finally:
            if self._read_ahead is not None:
                self._read_ahead.close()
        return played

    def _play(self) -> int:
        """Play the bags once; return the number of messages that were played."""
        count, control = 0, self._control
        self._last_time = None
        read_ahead, self._read_ahead = self._read_ahead, None
        with read_ahead or ReadAhead(self._messages()) as source:
            while not control.end_requested:
                batch = source.take(_POLL_PERIOD)
                if batch is None:
                    break
                if not batch:
                    control.wait(0)
                for item in batch:
                    if not self._wait_until_due(item):
                        return count
                    self._publish(item)
                    count += 1
        return count

    def _publish(self, item: PlayItem) -> None:
        send = self._send_functions.get((item.bag_index, item.message.connection.id))
        if send is not None:
            send(AnyMsg(item.message.data))

    def _wait_until_due(self, item: PlayItem) -> bool:
        """Wait until a message is due; return False if the user ends playback."""
        control, timeline, options, time = self._control, self._timeline, self._options, item.message.time
        now = perf_counter()
        if self._last_time is None:
            self._start_clock(time, now)
        elif options.skip_empty is not None and time - self._last_time > options.skip_empty * NS_PER_S:
            self._jump_to(time, now)
        if (
            self._pause_topics
            and control.pause_on_topics
            and item.message.connection.topic.lstrip("/") in self._pause_topics
        ):
            control.set_paused(True)
        self._last_time = time
        while not control.end_requested:
            must_wait = control.is_paused or self._is_delayed(timeline.bag_time_at(now))
            if must_wait or timeline.is_paused:
                timeline.set_paused(now, must_wait)
            if control.is_paused and control.steps:
                control.steps -= 1
                return self._step(time, now)
            if not must_wait and options.immediate:
                return self._step(time, now)
            due_at = inf if must_wait else timeline.wall_time_at(time)
            if now >= self._clock_ticker.due_at or now >= self._status_ticker.due_at:
                self._report(min(timeline.bag_time_at(now), time), now)
            if due_at <= now:
                return True
            control.wait(min(due_at, self._clock_ticker.due_at, self._status_ticker.due_at) - now)
            now = perf_counter()
        return False

    def _start_clock(self, time: int, now: float) -> None:
        self._timeline.set(time, now)
        self._clock_ticker.due_at = now
        self._status_ticker.due_at = now
        if self.rate_stamp is not None:
            self.rate_stamp = time

    def _is_delayed(self, time: int) -> bool:
        return self.rate_stamp is not None and time - self.rate_stamp > self._options.max_delay * NS_PER_S

    def _step(self, time: int, now: float) -> bool:
        """Jump to a message's time; return False if the user has ended playback."""
        self._jump_to(time, now)
        if now >= self._status_ticker.due_at:
            self._control.wait(0)
            self._report(time, now)
        return not self._control.end_requested

    def _jump_to(self, time: int, now: float) -> None:
        """Set the bag time to the time of the next message, and publish it on /clock."""
        self._timeline.set(time, now)
        self._publish_clock(time)
        if now >= self._clock_ticker.due_at:
            self._clock_ticker.tick(now)

    def _report(self, time: int, now: float) -> None:
        """Publish /clock and the status, if they are due."""
        if now >= self._clock_ticker.due_at:
            self._clock_ticker.tick(now)
            self._publish_clock(time)
        if now >= self._status_ticker.due_at:
            self._status_ticker.tick(now)
            self._control.wait(0)  # to read keys even if messages follow each other so fast that there is no other wait
            if self._on_status is not None:
                state = "PAUSED" if self._control.is_paused else "DELAYED" if self._timeline.is_paused else "RUNNING"
                self._on_status(
                    Status(state, time / NS_PER_S, (time - self._start) / NS_PER_S, self._length / NS_PER_S)
                )

    def _publish_clock(self, time: int) -> None:
        if self._options.clock_rate:
            self._clock.publish(self._clock_class(Time(*divmod(time, NS_PER_S))))
