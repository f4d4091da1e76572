"""One client: does what its frames say, and makes the frames for it. No sockets here.

`handle` is called by one thread at a time, and so is `take`.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from pyros1.ground.errors import Error
from pyros1.web.hub import Arrival
from pyros1.web.robot import Robot
from pyros1.web.rosbridge import frames, operations, values
from pyros1.web.rosbridge.calling import Calling
from pyros1.web.rosbridge.intake import Intake
from pyros1.web.rosbridge.operations import LEVELS, Action, BridgeError, Id
from pyros1.web.rosbridge.outbox import Flow, Frame, Outbox
from pyros1.web.rosbridge.providing import Providing
from pyros1.web.rosbridge.publishers import Publishers

MOST_TOPICS = 500
MOST_CALLS = 500
"""Most calls that run or wait at the same time."""


class Client:
    """A client.

    Args:
        robot: what it may see and do.
        start: runs a function in another thread, soon.
        wake: called, from any thread, when `take` may return something.
    """

    def __init__(
        self, robot: Robot, start: Callable[[Callable[[], object]], object], wake: Callable[[], object]
    ) -> None:
        self._robot = robot
        self._start = start
        self.outbox = Outbox(wake)
        self._intake = Intake()
        self._level = LEVELS.index("error")
        self._flows: dict[str, Flow] = {}
        self._publishers = Publishers(robot)
        self._providing = Providing(robot, self.outbox.tell)
        self._calling = Calling(robot)
        self._room = threading.Semaphore(MOST_CALLS)
        self._parts = 0

    def handle(self, received: Iterable[str | bytes]) -> None:
        """Do what frames say, in order. What is wrong with one is told to the client."""
        for frame in received:
            id: Id = None
            try:
                found = self._intake.take(frame)
                if found is not None:
                    id, action = found
                    self._do(id, action)
            except BridgeError as error:
                self._tell("error", str(error), id if error.id is None else error.id)
            except Error as error:
                self._tell("error", str(error), id)

    def _do(self, id: Id, action: Action) -> None:
        match action:
            case operations.Publish():
                self._check_may_change()
                self._publishers.publish(action.topic, action.message)
            case operations.Advertise():
                self._check_may_change()
                self._publishers.advertise(action)
            case operations.Unadvertise():
                if not self._publishers.unadvertise(action.topic):
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
        topic = self._robot.node.resolve(wish.topic)
        self._robot.check_visible(topic)
        if wish.type:
            kind = self._robot.graph.topic_types().get(topic, "*")
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
        try:
            # Once more for each subscription: who comes later gets a latched message, too.
            flow.end = self._robot.listen(topic, lambda arrival: self.outbox.put(flow, arrival))
        except Error:
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
        if not self._room.acquire(blocking=False):
            self.outbox.tell(frames.text(frames.response(call.service, id, "too many calls at the same time", False)))
            return

        def run() -> None:
            try:
                for frame in self._calling.answer(id, call):
                    self.outbox.tell(frame)
            finally:
                self._room.release()

        self._start(run)

    def take(self, now: float) -> tuple[Iterator[Frame], float | None]:
        """Return the frames that are due, which are made as they are taken, and when to call again.

        Args:
            now: seconds of a clock that does not jump.

        Returns:
            The frames, and a time; None if there is nothing to do before it wakes.
        """
        told, arrivals, again = self.outbox.take(now)

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
        self._calling.close()
        for flow in self._flows.values():
            flow.end()
        self._flows.clear()
        self._publishers.close()
        self._providing.close()
