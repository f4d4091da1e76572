"""Handles the frames from one client, and creates the frames for it, without using sockets.

Only one thread at a time may call `handle`, and only one at a time may call `take`. Operations are performed in the
order of their frames; an operation that follows subscriptions waits until these are established.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from time import monotonic
from typing import NamedTuple

from pyros1.ground.errors import Error
from pyros1.web.hub import Arrival
from pyros1.web.robot import Robot
from pyros1.web.rosbridge import frames, operations, values
from pyros1.web.rosbridge.frame_decoder import FrameDecoder
from pyros1.web.rosbridge.operations import LEVELS, Action, BridgeError, Id
from pyros1.web.rosbridge.outbox import Outbox, TopicQueue
from pyros1.web.rosbridge.provided_services import ProvidedServices
from pyros1.web.rosbridge.publishers import Publishers
from pyros1.web.rosbridge.service_caller import ServiceCaller
from pyros1.web.rosbridge.shared_encodings import SharedEncodings
from pyros1.web.server.sending import Frame, LargeFrame, frame_size
from pyros1.web.server.waiting import PendingOperations
from pyros1.web.service_calls import MAX_CONCURRENT_CALLS

MAX_TOPICS = 500
MAX_CALLS = 500
"""Maximum number of a client's service calls, running and queued."""
_MAX_QUICK_MESSAGES = 32
_MAX_QUICK_BYTES = 16_000
"""Maximum total size in bytes of messages whose encoding counts as quick: it takes about a millisecond."""
_MAX_QUICK_RAW_BYTES = 1 << 20
"""Like `_MAX_QUICK_BYTES`, but for frames, and for messages that are only copied."""


class DueFrames(NamedTuple):
    """The frames that are due for a client.

    Attributes:
        frames: the frames, which are created lazily.
        is_quick: whether creating them takes so little time that no other thread is needed.
        next_time: the monotonic time at which to call `Client.take` again; None if there is nothing to do until
            ``wake`` is called.
    """

    frames: Iterator[Frame]
    is_quick: bool
    next_time: float | None


class Client:
    """One rosbridge client.

    Args:
        robot: the robot, with the access rules for clients.
        run_in_thread: starts a function in another thread.
        wake: called, from any thread, when `take` may return something.
        resume: called, from any thread, when `handle` may continue.
        shared_encodings: the cache of encoded frames that all clients share.
        send_now: sends frames without waiting, from any thread; returns False if it cannot send them now. None if all
            frames must be taken by `take`.
        on_fault: called, from any thread, with an unexpected error.
        on_refusal: called, from any thread, with the text of each error sent to the client.

    Attributes:
        pending_subscriptions: the subscriptions in progress.
        outbox: the outgoing frames and messages.
    """

    def __init__(
        self,
        robot: Robot,
        run_in_thread: Callable[[Callable[[], object]], object],
        wake: Callable[[], object],
        resume: Callable[[], object] = lambda: None,
        shared_encodings: SharedEncodings | None = None,
        send_now: Callable[[Iterable[Frame]], bool] | None = None,
        on_fault: Callable[[Exception], object] = lambda error: None,
        on_refusal: Callable[[str], object] = lambda text: None,
    ) -> None:
        self._robot = robot
        self._run_in_thread = run_in_thread
        self.outbox = Outbox(wake)
        self.pending_subscriptions = PendingOperations(resume)
        self._frames_to_handle: deque[str | bytes] = deque()
        self._deferred_operation: tuple[Id, Action] | None = None  # waits for subscriptions
        self._decoder = FrameDecoder()
        self._status_level = LEVELS.index("error")
        self._queues: dict[str, TopicQueue] = {}
        self._publishers = Publishers(robot)
        self._provided_services = ProvidedServices(robot, self.outbox)
        self._service_caller = ServiceCaller(robot)
        self._calls_lock = threading.Lock()
        self._queued_calls: deque[tuple[Id, operations.CallService]] = deque()
        self._num_running_calls = 0
        self._num_messages = 0
        self._shared_encodings = shared_encodings or SharedEncodings()
        self._send_now = send_now
        self._on_fault = on_fault
        self._on_refusal = on_refusal

    def handle(self, received: Iterable[str | bytes]) -> bool:
        """Handle frames from the client in order. Errors are reported to the client.

        Returns:
            Whether all frames have been handled. If not, call this again without new frames as soon as `resume` is
            called.
        """
        self._frames_to_handle.extend(received)
        while self._deferred_operation is not None or self._frames_to_handle:
            if not self._handle_next():
                return False
        return True

    def _handle_next(self) -> bool:
        """Handle the deferred operation or the next frame; return False if its operation must wait."""
        id: Id = None
        try:
            operation = self._deferred_operation or self._decoder.decode(self._frames_to_handle.popleft())
            if operation is not None:
                id, action = operation
                if self.pending_subscriptions and not isinstance(action, operations.Subscribe):
                    self._deferred_operation = operation
                    return False
                self._deferred_operation = None
                self._perform(id, action)
        except BridgeError as error:
            self._send_status("error", str(error), id if error.id is None else error.id)
        except Error as error:
            self._send_status("error", str(error), id)
        return True

    def _perform(self, id: Id, action: Action) -> None:
        match action:
            case operations.Publish():
                self._check_may_change()
                self._publishers.publish(action)
            case operations.Advertise():
                self._check_may_change()
                self._publishers.advertise(action, id)
            case operations.Unadvertise():
                if not self._publishers.unadvertise(action.topic, id):
                    self._send_status("warning", f"you do not advertise {action.topic}", id)
            case operations.Subscribe():
                self._subscribe(action)
            case operations.Unsubscribe():
                if not self._unsubscribe(action):
                    self._send_status("warning", f"you do not subscribe to {action.topic}", id)
            case operations.CallService():
                self._queue_call(id, action)
            case operations.AdvertiseService():
                self._check_may_change()
                self._provided_services.advertise(action.service, action.type)
            case operations.UnadvertiseService():
                self._provided_services.unadvertise(action.service)
            case operations.ServiceResponse():
                self._provided_services.pass_response(id, action)
            case operations.SetLevel():
                self._status_level = LEVELS.index(action.level)

    def _check_may_change(self) -> None:
        if self._robot.access.read_only:
            raise BridgeError("this server is read-only (--read-only)")

    def _send_status(self, level: str, message: str, id: Id = None) -> None:
        if level == "error":
            self._on_refusal(message)
        if LEVELS.index(level) <= self._status_level:
            self.outbox.enqueue(frames.status(level, message, id))

    def _subscribe(self, request: operations.Subscribe) -> None:
        topic = self._robot.full_name(request.topic)
        self._robot.check_visible(topic)
        if request.type:
            type_name = self._robot.type_of(topic, request.type)
            if type_name not in ("*", request.type):
                raise BridgeError(f"{topic} has messages of the type {type_name}, not {request.type}")
        queue = self._queues.get(request.topic)
        if queue is None:
            if len(self._queues) >= MAX_TOPICS:
                raise BridgeError(f"a client can subscribe to at most {MAX_TOPICS} topics")
            queue = self._queues[request.topic] = TopicQueue(request.topic)
            self.outbox.add(queue)
        elif request.key not in queue.requests and len(queue.requests) >= MAX_TOPICS:
            raise BridgeError(f"a client can subscribe to a topic at most {MAX_TOPICS} times")
        queue.add_subscription(request)
        unsubscribe_previous, queue.last_arrival = queue.unsubscribe, None
        done = self.pending_subscriptions.begin()
        try:
            # Add a new listener for each subscription, so that later subscriptions also get the latched messages.
            queue.unsubscribe = self._robot.listen(topic, lambda arrival: self._on_arrival(queue, arrival), done)
        except Error:
            done()
            self._unsubscribe(operations.Unsubscribe(request.topic, request.key))
            raise
        unsubscribe_previous()

    def _unsubscribe(self, action: operations.Unsubscribe) -> bool:
        queue = self._queues.get(action.topic)
        if queue is None or (action.key is not None and action.key not in queue.requests):
            return False
        queue.remove_subscription(action.key)
        if not queue.requests:
            del self._queues[action.topic]
            self.outbox.remove(queue)
            queue.unsubscribe()
        return True

    def _queue_call(self, id: Id, call: operations.CallService) -> None:
        with self._calls_lock:
            is_refused = self._num_running_calls + len(self._queued_calls) >= MAX_CALLS
            if not is_refused:
                self._queued_calls.append((id, call))
        if is_refused:
            self.outbox.enqueue(
                frames.to_json(frames.response(call.service, id, "too many calls at the same time", False))
            )
        self._start_calls()

    def _start_calls(self) -> None:
        """Start as many queued calls as possible, but none while the client does not read its responses."""
        while not self.outbox.is_full():
            with self._calls_lock:
                if not self._queued_calls or self._num_running_calls >= MAX_CONCURRENT_CALLS:
                    return
                self._num_running_calls += 1
                id, call = self._queued_calls.popleft()
            self._run_in_thread(partial(self._run_call, id, call))

    def _run_call(self, id: Id, call: operations.CallService) -> None:
        try:
            for frame in self._service_caller.call(id, call):
                self.outbox.enqueue(frame)
        finally:
            with self._calls_lock:
                self._num_running_calls -= 1
        self._start_calls()

    def take(self, now: float) -> DueFrames:
        """Return the frames that are due.

        Args:
            now: monotonic time in seconds.
        """
        ready_frames, arrivals, next_time = self.outbox.take(now)
        self._start_calls()
        is_quick = _is_quick(ready_frames, arrivals)

        def generate() -> Iterator[Frame]:
            yield from ready_frames
            for queue, arrival in arrivals:
                yield from self._message_frames(queue, arrival, may_wait=not is_quick)

        return DueFrames(generate(), is_quick, next_time)

    def _on_arrival(self, queue: TopicQueue, arrival: Arrival) -> None:
        """Send a message immediately if that is quick and nothing else is waiting to be sent; otherwise queue it."""
        send_now = self._send_now
        may_send = send_now is not None and self.outbox.is_free and _may_send_now(queue, arrival)
        if not self.outbox.put(queue, arrival, may_send) or send_now is None:
            return
        unsent: Arrival | None = None
        try:
            if not send_now(list(self._message_frames(queue, arrival, may_wait=False))):
                unsent = arrival
        except Exception as error:  # noqa: BLE001 - a bug, which must not end the topic's thread
            self._on_fault(error)
        finally:
            self.outbox.end_sending(queue, unsent, monotonic())

    def _message_frames(self, queue: TopicQueue, arrival: Arrival, may_wait: bool) -> Iterator[Frame]:
        """Yield the frames for a message; none if it cannot be encoded, which is then reported to the client."""
        form, topic = queue.compression, queue.name
        try:
            frame = self._shared_encodings.get(
                arrival, form, topic, lambda: encode_message(arrival, form, topic), may_wait
            )
            queue.problem = ""
        except Error as error:
            if str(error) != queue.problem:  # report each problem only once
                queue.problem = str(error)
                self._send_status("error", f"{queue.name}: {error}")
            return
        if isinstance(frame, bytes) or (
            isinstance(frame, LargeFrame) and (not frame.is_text or not queue.fragment_size)
        ):
            yield frame
            return
        self._num_messages += 1
        yield from frames.split(frames.as_text(frame), queue.fragment_size, f"{topic}:{self._num_messages}")

    def close(self) -> None:
        """End all subscriptions, publishers, services and calls."""
        with self._calls_lock:
            self._queued_calls.clear()
        self._service_caller.close()
        for queue in self._queues.values():
            queue.unsubscribe()
        self._queues.clear()
        self._publishers.close()
        self._provided_services.close()


def _is_quick(ready_frames: list[Frame], arrivals: list[tuple[TopicQueue, Arrival]]) -> bool:
    """Return whether encoding messages takes so little time that using another thread would take longer."""
    if len(arrivals) > _MAX_QUICK_MESSAGES:
        return False
    size, raw_size = 0, sum(map(frame_size, ready_frames))
    for queue, arrival in arrivals:
        if queue.fragment_size is not None:
            return False
        if queue.compression == "cbor-raw":
            raw_size += len(arrival.raw._buff)
        elif queue.compression == "png" or not arrival.has_class:
            return False
        elif queue.compression == "cbor" and values.is_flat(arrival.message_class):
            raw_size += len(arrival.raw._buff)
        else:
            size += len(arrival.raw._buff)
    return size <= _MAX_QUICK_BYTES and raw_size <= _MAX_QUICK_RAW_BYTES


def _may_send_now(queue: TopicQueue, arrival: Arrival) -> bool:
    """Return whether a message may be encoded in the thread in which it arrives, while the topic's other clients wait.

    Large arrays that are not converted, or only to base64, are no reason to use another thread, which would hold the
    interpreter's lock for just as long.
    """
    size = len(arrival.raw._buff)
    if queue.fragment_size is not None or queue.compression == "png":
        return False
    if queue.compression == "cbor-raw":
        return True
    if not arrival.has_class:
        return False
    if queue.compression == "cbor":
        return size <= _MAX_QUICK_BYTES or values.is_flat(arrival.message_class)
    return size <= _MAX_QUICK_BYTES or (size <= _MAX_QUICK_RAW_BYTES and values.has_only_bytes(arrival.message_class))


def encode_message(arrival: Arrival, form: str, topic: str) -> Frame:
    """Return the frame for a message; ``form`` is the client's form of compression."""
    data = arrival.raw._buff
    if form == "cbor-raw":
        secs, fraction = divmod(arrival.time, 1)
        raw = {"secs": int(secs), "nsecs": int(fraction * 1e9), "bytes": data}
        return frames.publish_cbor(topic, raw, len(data))
    message = values.decode(arrival.message_class, data)
    if form == "cbor":
        return frames.publish_cbor(topic, values.for_cbor(message), len(data))
    frame = frames.publish(topic, message)
    return frames.compress(frames.as_text(frame), form) if form == "png" else frame
