"""Queues the data sent to a client (no I/O, bounded, thread-safe). For a slow client, old messages are dropped."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from pyros1.web.rosbridge.operations import Id, Subscribe
from pyros1.web.server.sending import Frame, frame_size
from pyros1.web.server.turns import Turns

if TYPE_CHECKING:
    from pyros1.web.hub import Arrival

MAX_MESSAGES = 1000
"""Maximum number of messages queued per topic."""
MAX_BYTES = 4 << 20
"""Maximum size in bytes of the messages queued per topic; one message is always queued, whatever its size."""
MAX_TOTAL_BYTES = 32 << 20
"""Like `MAX_BYTES`, but for all topics together."""
MAX_FRAME_BYTES = 1 << 20
"""Size in bytes of queued responses above which no more requests are read from the client."""
_BATCH_BYTES = 1 << 20
"""Size in bytes after which one call of `take` returns no more messages."""


class TopicQueue:
    """The queued messages of a topic to which the client subscribes.

    Attributes:
        name: the topic's name as sent by the client.
        requests: the client's subscriptions to the topic, by id.
        compression, fragment_size: the form of frames that the client has requested.
        unsubscribe: ends the subscription.
        problem: why the last message could not be sent; empty if it could.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.requests: dict[Id, Subscribe] = {}
        self.unsubscribe: Callable[[], object] = lambda: None
        self.problem = ""
        self.compression = "none"
        self.fragment_size: int | None = None
        self.messages: deque[Arrival] = deque()
        self.size = 0
        self.max_length = MAX_MESSAGES
        self.throttle_period = 0.0
        self.last_arrival: Arrival | None = None
        self.next_time = float("-inf")
        self.is_open = False  # whether the queue belongs to an outbox

    def add_subscription(self, request: Subscribe) -> None:
        """Add a subscription.

        If there are several subscriptions, the highest rate, the longest queue and the smallest frames that any of them
        requests are used, and the compression that the last one requests.
        """
        self.requests.pop(request.key, None)
        self.requests[request.key] = request
        self._merge_settings()

    def remove_subscription(self, key: Id) -> None:
        """Remove the subscription with the id ``key``, or all subscriptions if ``key`` is None."""
        if key is None:
            self.requests.clear()
        else:
            self.requests.pop(key, None)
        if self.requests:
            self._merge_settings()

    def _merge_settings(self) -> None:
        requests = list(self.requests.values())
        throttle_period = min(request.throttle for request in requests)
        self.next_time += throttle_period - self.throttle_period
        self.throttle_period = throttle_period
        length = max(request.queue_length for request in requests)
        self.max_length = min(length, MAX_MESSAGES) or (1 if throttle_period else MAX_MESSAGES)
        self.fragment_size = min((request.fragment_size for request in requests if request.fragment_size), default=None)
        self.compression = requests[-1].compression

    def pop(self) -> Arrival:
        """Remove and return the oldest message."""
        arrival = self.messages.popleft()
        self.size -= len(arrival.raw._buff)
        return arrival


class Outbox:
    """All data queued for one client.

    Args:
        wake: called, from any thread, when something has been queued.
    """

    def __init__(self, wake: Callable[[], object]) -> None:
        self._wake = wake
        self._lock = threading.Lock()
        self._frames: deque[Frame] = deque()
        self._frames_size = 0
        self._queues: list[TopicQueue] = []
        self._turns = Turns()

    def enqueue(self, frame: Frame) -> None:
        """Add a response. Responses are never dropped: while `is_full`, no more requests should be accepted."""
        with self._lock:
            self._frames.append(frame)
            self._frames_size += frame_size(frame)
            must_wake = self._turns.leave_to_loop()
        if must_wake:
            self._wake()

    def is_full(self) -> bool:
        """Return whether the client should read its responses before it sends more requests."""
        return self._frames_size > MAX_FRAME_BYTES

    def is_overfull(self) -> bool:
        """Return whether even calls to the client's services should be refused."""
        return self._frames_size > MAX_TOTAL_BYTES

    def add(self, queue: TopicQueue) -> None:
        """Add a topic's queue."""
        with self._lock:
            self._queues.append(queue)
            queue.is_open = True

    def remove(self, queue: TopicQueue) -> None:
        """Remove a topic's queue with its messages."""
        with self._lock:
            self._queues = [each for each in self._queues if each is not queue]
            queue.is_open = False

    @property
    def is_free(self) -> bool:
        """Whether a message might be sent immediately: nothing is queued, and nothing is being sent."""
        return self._turns.is_free

    def put(self, queue: TopicQueue, arrival: Arrival, may_send: bool = False) -> bool:
        """Add a message to a topic's queue; its oldest messages are dropped if there is no space.

        Args:
            queue: the topic's queue.
            arrival: the message.
            may_send: whether the caller may send the message instead.

        Returns:
            Whether the caller must now send the message, which has not been queued, and then call `end_sending`.
        """
        with self._lock:
            if arrival is queue.last_arrival:
                return False  # while a client subscribes to the topic again, each message arrives twice
            queue.last_arrival = arrival
            if may_send and not queue.throttle_period and queue.is_open and self._turns.begin():
                return True
            queue.messages.append(arrival)
            must_wake = self._added(queue, arrival)
        if must_wake:
            self._wake()
        return False

    def _added(self, queue: TopicQueue, arrival: Arrival) -> bool:
        queue.size += len(arrival.raw._buff)
        while len(queue.messages) > 1 and (
            len(queue.messages) > queue.max_length or queue.size > MAX_BYTES or self._size() > MAX_TOTAL_BYTES
        ):
            queue.pop()
        return self._turns.leave_to_loop()

    def end_sending(self, queue: TopicQueue, unsent: Arrival | None, now: float) -> None:
        """End the sending that `put` requested.

        Args:
            queue: the topic's queue.
            unsent: the message if it could not be sent; it is then queued before those that have arrived meanwhile.
            now: monotonic time in seconds.
        """
        with self._lock:
            if unsent is None:
                queue.next_time = now + queue.throttle_period
            else:
                queue.messages.appendleft(unsent)
                self._added(queue, unsent)
            must_wake = self._turns.end()
        if must_wake:
            self._wake()

    def release(self) -> None:
        """Let messages be sent immediately from now on if nothing is queued. Called when everything taken has been
        sent.
        """
        with self._lock:
            if not self._frames and not any(queue.messages for queue in self._queues):
                self._turns.release()

    def _size(self) -> int:
        return sum(each.size for each in self._queues)

    def take(self, now: float) -> tuple[list[Frame], list[tuple[TopicQueue, Arrival]], float | None]:
        """Remove the data that is due, and return it.

        Args:
            now: monotonic time in seconds.

        Returns:
            The responses, the messages in order of arrival, and the monotonic time at which to call this again. The
            time is None if nothing is due until `wake` is called.
        """
        with self._lock:
            if self._turns.is_threads:
                return [], [], None
            ready_frames, self._frames, self._frames_size = list(self._frames), deque(), 0
            due_queues = [queue for queue in self._queues if queue.messages and queue.next_time <= now]
            arrivals: list[tuple[TopicQueue, Arrival]] = []
            size = 0
            while due_queues and size < _BATCH_BYTES:
                for queue in due_queues:
                    arrival = queue.pop()
                    size += len(arrival.raw._buff)
                    arrivals.append((queue, arrival))
                    queue.next_time = now + queue.throttle_period
                    if size >= _BATCH_BYTES:
                        break
                due_queues = [queue for queue in due_queues if queue.messages and not queue.throttle_period]
            if size >= _BATCH_BYTES:  # queues from which nothing was taken now come first next time
                self._queues.sort(key=lambda queue: queue.next_time)
            next_time = min([queue.next_time for queue in self._queues if queue.messages], default=None)
        if len(arrivals) > 1:
            arrivals.sort(key=lambda queue_and_arrival: queue_and_arrival[1].arrived_at)
        return ready_frames, arrivals, next_time
