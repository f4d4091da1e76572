"""One client: does what its frames say, and makes the frames for it. No sockets here.

`handle` is called by one thread at a time, and so is `take`. Operations are done in the order of their frames: one that
comes behind subscriptions waits until these are made.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any

from pyros1.ground.errors import Error
from pyros1.web.exchanges import AT_ONCE
from pyros1.web.hub import Arrival
from pyros1.web.robot import Robot
from pyros1.web.rosbridge import frames, operations, values
from pyros1.web.rosbridge.calling import Calling
from pyros1.web.rosbridge.intake import Intake
from pyros1.web.rosbridge.operations import LEVELS, Action, BridgeError, Id
from pyros1.web.rosbridge.outbox import Flow, Frame, Outbox
from pyros1.web.rosbridge.providing import Providing
from pyros1.web.rosbridge.publishers import Publishers
from pyros1.web.server.waiting import Pending

MOST_TOPICS = 500
MOST_CALLS = 500
"""Most calls that run or wait at the same time."""


class Client:
    """A client.

    Args:
        robot: what it may see and do.
        start: runs a function in another thread, soon.
        wake: called, from any thread, when `take` may return something.
        go_on: called, from any thread, when `handle` may go on.

    Attributes:
        subscribing: the subscriptions that are not made yet.
        outbox: what waits to be sent.
    """

    def __init__(
        self,
        robot: Robot,
        start: Callable[[Callable[[], object]], object],
        wake: Callable[[], object],
        go_on: Callable[[], object] = lambda: None,
    ) -> None:
        self._robot = robot
        self._start = start
        self.outbox = Outbox(wake)
        self.subscribing = Pending(go_on)
        self._frames_left: deque[str | bytes] = deque()
        self._next: tuple[Id, Action] | None = None  # it waits for subscriptions
        self._intake = Intake()
        self._level = LEVELS.index("error")
        self._flows: dict[str, Flow] = {}
        self._publishers = Publishers(robot)
        self._providing = Providing(robot, self.outbox)
        self._calling = Calling(robot)
        self._calls_lock = threading.Lock()
        self._calls: deque[tuple[Id, operations.CallService]] = deque()  # they wait
        self._running = 0
        self._parts = 0

    def handle(self, received: Iterable[str | bytes]) -> bool:
        """Do what frames say, in order. What is wrong with one is told to the client.

        Returns:
            Whether all is done. If not, it is to be called again, without frames, when `subscribing` is over.
        """
        self._frames_left.extend(received)
        while self._next is not None or self._frames_left:
            if not self._handle_next():
                return False
        return True

    def _handle_next(self) -> bool:
        """Do one thing; return False if it has to wait."""
        id: Id = None
        try:
            found = self._next or self._intake.take(self._frames_left.popleft())
            if found is not None:
                id, action = found
                if self.subscribing and not isinstance(action, operations.Subscribe):
                    self._next = found
                    return False
                self._next = None
                self._do(id, action)
        except BridgeError as error:
            self._tell("error", str(error), id if error.id is None else error.id)
        except Error as error:
            self._tell("error", str(error), id)
        return True

    def _do(self, id: Id, action: Action) -> None:
        match action:
            case operations.Publish():
                self._check_may_change()
                self._publishers.publish(action)
            case operations.Advertise():
                self._check_may_change()
                self._publishers.advertise(action, id)
            case operations.Unadvertise():
                if not self._publishers.unadvertise(action.topic, id):
                    self._tell("warning", f"you do not advertise {action.topic}", id)
            case operations.Subscribe():
                self._subscribe(action)
            case operations.Unsubscribe():
                if not self._unsubscribe(action):
                    self._tell("warning", f"you do not subscribe to {action.topic}", id)
            case operations.CallService():
                self._call(id, action)
            case operations.AdvertiseService():
                self._check_may_change()
                self._providing.advertise(action.service, action.type)
            case operations.UnadvertiseService():
                self._providing.unadvertise(action.service)
            case operations.ServiceResponse():
                self._providing.answer(id, action)
            case operations.SetLevel():
                self._level = LEVELS.index(action.level)

    def _check_may_change(self) -> None:
        if self._robot.access.read_only:
            raise BridgeError("this server is read-only (--read-only)")

    def _tell(self, level: str, message: str, id: Id = None) -> None:
        if LEVELS.index(level) <= self._level:
            self.outbox.tell(frames.status(level, message, id))

    def _subscribe(self, wish: operations.Subscribe) -> None:
        topic = self._robot.full_name(wish.topic)
        self._robot.check_visible(topic)
        if wish.type:
            kind = self._robot.type_of(topic, wish.type)
            if kind not in ("*", wish.type):
                raise BridgeError(f"{topic} has messages of the type {kind}, not {wish.type}")
        flow = self._flows.get(wish.topic)
        if flow is None:
            if len(self._flows) >= MOST_TOPICS:
                raise BridgeError(f"a client subscribes to at most {MOST_TOPICS} topics")
            flow = self._flows[wish.topic] = Flow(wish.topic)
            self.outbox.add(flow)
        elif wish.key not in flow.wishes and len(flow.wishes) >= MOST_TOPICS:
            raise BridgeError(f"a client subscribes to a topic at most {MOST_TOPICS} times")
        flow.wish(wish)
        before, flow.last = flow.end, None
        done = self.subscribing.begin()
        try:
            # Once more for each subscription: who comes later gets a latched message, too.
            flow.end = self._robot.listen(topic, lambda arrival: self.outbox.put(flow, arrival), done)
        except Error:
            done()
            self._unsubscribe(operations.Unsubscribe(wish.topic, wish.key))
            raise
        before()

    def _unsubscribe(self, action: operations.Unsubscribe) -> bool:
        flow = self._flows.get(action.topic)
        if flow is None or (action.key is not None and action.key not in flow.wishes):
            return False
        flow.unwish(action.key)
        if not flow.wishes:
            del self._flows[action.topic]
            self.outbox.remove(flow)
            flow.end()
        return True

    def _call(self, id: Id, call: operations.CallService) -> None:
        with self._calls_lock:
            refused = self._running + len(self._calls) >= MOST_CALLS
            if not refused:
                self._calls.append((id, call))
        if refused:
            self.outbox.tell(frames.text(frames.response(call.service, id, "too many calls at the same time", False)))
        self._start_calls()

    def _start_calls(self) -> None:
        """Start calls that wait. While the client does not read its answers, there are to be no more."""
        while not self.outbox.is_full():
            with self._calls_lock:
                if not self._calls or self._running >= AT_ONCE:
                    return
                self._running += 1
                id, call = self._calls.popleft()
            self._start(partial(self._run, id, call))

    def _run(self, id: Id, call: operations.CallService) -> None:
        try:
            for frame in self._calling.answer(id, call):
                self.outbox.tell(frame)
        finally:
            with self._calls_lock:
                self._running -= 1
        self._start_calls()

    def take(self, now: float) -> tuple[Iterator[Frame], float | None]:
        """Return the frames that are due, which are made as they are taken, and when to call again.

        Args:
            now: seconds of a clock that does not jump.

        Returns:
            The frames, and a time; None if there is nothing to do before it wakes.
        """
        told, arrivals, again = self.outbox.take(now)
        self._start_calls()

        def made() -> Iterator[Frame]:
            yield from told
            for flow, arrival in arrivals:
                try:
                    yield from self._frames(flow, arrival)
                    flow.problem = ""
                except Error as error:
                    if str(error) != flow.problem:  # once, not with each message
                        flow.problem = str(error)
                        self._tell("error", f"{flow.name}: {error}")

        return made(), again

    def _frames(self, flow: Flow, arrival: Arrival) -> Iterator[Frame]:
        frame: dict[str, Any] = {"op": "publish", "topic": flow.name}
        data = arrival.raw._buff
        if flow.compression == "cbor-raw":
            secs, part = divmod(arrival.time, 1)
            yield frames.binary({**frame, "msg": {"secs": int(secs), "nsecs": int(part * 1e9), "bytes": data}})
            return
        message = values.decode(arrival.message_class, data)
        if flow.compression == "cbor":
            yield frames.binary({**frame, "msg": values.for_cbor(message)})
            return
        self._parts += 1
        text = frames.text({**frame, "msg": values.for_json(message)})
        yield from frames.packed(text, flow.compression, flow.fragment_size, f"{flow.name}:{self._parts}")

    def close(self) -> None:
        """End all."""
        with self._calls_lock:
            self._calls.clear()
        self._calling.close()
        for flow in self._flows.values():
            flow.end()
        self._flows.clear()
        self._publishers.close()
        self._providing.close()
