"""The joints of a robot: their limits, where they are, and sliders that move them."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error, MessageError, ParameterNotSetError
from pyros1.urdf.joints import JointStates
from pyros1.urdf.reading import read
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.tables import joints
from pyros1.web.tables.repeating import Repeating
from pyros1.web.views.view import View, text

if TYPE_CHECKING:
    from pyros1.web.hub import Arrival
    from pyros1.web.robot import Robot

_PARAMETER = "/robot_description"
_LOOK = 1.0
"""Seconds between two looks at the description, and at who publishes."""
_HZ = 10.0
_TYPE = "sensor_msgs/JointState"
_MOST_NAMES = 50


class _PublishedElsewhereError(RequestError):
    """Another view publishes the joints."""


class JointsView(View):
    """Shows the joints of a description, and moves them.

    A node that publishes the joints goes on doing so, and is told where they shall be: on the topic ``~sliders`` of
    pyros1's joint_state_publisher, or on one of the source_list of any other. If nobody publishes, this view can; of
    several, the first, and then one that was opened to publish.

    Args (of the page):
        description: name of the parameter; the topic is the joint_states beside it.
        publish: whether to publish the joints while this is open, if nobody else does.
        positions: joint -> where it shall be, in radians or metres. `change` moves joints by these.

    Pushes ``{"facts": {...}, "positions": [...]}``, each only when it has changed; `_describe` says what the facts are.
    Positions are those of the joints; null for unknown.
    """

    period = 1 / 15
    polled = True

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._description = text(args, "description", _PARAMETER)
        self._topic = f"{self._description.rpartition('/')[0]}/joint_states"
        robot.check_visible(self._description)
        self._lock = threading.Lock()  # of the states, and of what was heard
        self._heard: dict[str, float] = {}
        self._states: JointStates | None = None
        self._problem = ""
        self._joints: list[dict[str, Any]] = []
        self._descriptions: list[str] = []
        self._known: Any = None  # description and publishers that the states are made of
        self._others: list[str] = []
        self._sources: list[tuple[str, str]] = []
        self._source = ""
        self._looked = float("-inf")
        self._pushed: dict[str, Any] = {}
        self._repeating: Repeating | None = None
        self._end = robot.listen(self._topic, self._arrived)
        self._waiting: Mapping[str, Any] | None = None  # until another view no longer publishes
        try:
            self._apply(args)
        except _PublishedElsewhereError:
            self._waiting = args  # perhaps by this page's former connection, which is not known to be dead yet
        except BaseException:
            self.close()
            raise

    def take(self) -> Push | None:
        if monotonic() - self._looked >= _LOOK:
            self._look()
            if self._waiting is not None:
                with suppress(_PublishedElsewhereError):
                    self._apply(self._waiting)
                    self._waiting = None
        if self._problem:
            raise RequestError(self._problem)
        now: dict[str, Any] = {"facts": self._describe()}
        with self._lock:
            now["positions"] = [self._heard.get(each["name"]) for each in self._joints]
        changed = {key: value for key, value in now.items() if value != self._pushed.get(key)}
        self._pushed = now
        return Push(changed) if changed else None

    def change(self, args: Mapping[str, Any]) -> None:
        self._waiting = None
        self._apply(args)

    def close(self) -> None:
        self._end()
        self._stop()

    def _apply(self, args: Mapping[str, Any]) -> None:
        positions, publish = joints.positions(args.get("positions", {})), bool(args.get("publish"))
        if not positions and not publish:
            self._stop()
            return
        if self.robot.access.read_only:
            raise RequestError("this server is read-only (--read-only)")
        self._look()
        mover = self.robot.movers.get(self._topic, self)
        if publish and not self._others:
            mover = self.robot.movers.setdefault(self._topic, self)
        if publish and mover is not self:  # whether the master lists its publisher yet or not
            raise _PublishedElsewhereError(f"another page is already publishing {self._topic}")
        if publish and not self._others:
            with self._lock:
                if self._states is not None:
                    self._states.take(list(positions), list(positions.values()))
            if self._repeating is None:
                self._repeating = Repeating(self._publish, _HZ)
        elif positions:
            self._move(positions)

    def _move(self, positions: Mapping[str, float]) -> None:
        if not self._source:
            raise RequestError(f"no node subscribes to {self._topic}")
        value = {"header": {"stamp": "now"}, "name": list(positions), "position": list(positions.values())}
        self.robot.publishing.publish(self._source, _TYPE, value)

    def _publish(self) -> int:
        with self._lock:
            if self._states is None:
                return 0
            names, positions, velocities, efforts = self._states.message()
        numbers = {"position": positions, "velocity": velocities, "effort": efforts}
        value = {"header": {"stamp": "now"}, "name": names, **numbers}
        return self.robot.publishing.publish(self._topic, _TYPE, value)

    def _stop(self) -> None:
        if self._repeating is not None:
            self._repeating.close()
            self._repeating = None
            self.robot.publishing.end(self._topic)
        if self.robot.movers.get(self._topic) is self:
            del self.robot.movers[self._topic]

    def _look(self) -> None:
        """Look who publishes what now."""
        self._looked = monotonic()
        node = self.robot.node
        description = node.params.cached(self._description)
        state = self.robot.graph.state()
        ours = node.name if self.robot.movers.get(self._topic, self) is self else ""  # else it is another page's
        self._others = sorted(name for name in state.publishers.get(self._topic, []) if name != ours)
        if (description, self._others) != self._known:
            self._known = (description, self._others)
            self._read(description)
        self._descriptions = [] if self._states else self._all_descriptions()
        takes = (topic for name, topic in self._sources if name in state.subscribers.get(topic, []))
        self._source = next((topic for topic in takes if self.robot.access.may_see(topic)), "")
        if self._others:
            self._stop()  # the robot's own driver has come: it shall not be contradicted

    def _read(self, description: Any) -> None:
        params = {name: self._private(name) for name in self._others[:_MOST_NAMES]}
        self._sources = [(name, topic) for name, values in params.items() for topic in joints.sources(name, values)]
        states, self._problem = None, ""
        if isinstance(description, str):
            try:
                states = JointStates(read(description), joints.chosen(next(iter(params.values()), {})))
            except Error as error:
                self._problem = f"{self._description}: {error}"
        with self._lock:
            self._states, self._heard = states, {}
            self._joints = joints.facts(states) if states else []

    def _private(self, node: str) -> Any:
        try:
            return self.robot.master.get_param(f"{node}/")
        except ParameterNotSetError:
            return {}

    def _describe(self) -> dict[str, Any]:
        """Return what the page shows, but for positions.

        ``description``, and ``descriptions``: all there are, if that one is not. ``joints``: see
        `pyros1.web.tables.joints.facts`; ``more``: how many are left out. ``topic``, ``publishers``: where states come
        from. ``movable``: whether somebody takes positions. ``publishing``: whether this view publishes.
        """
        states = self._states
        return {
            "description": self._description,
            "there": states is not None,
            "descriptions": self._descriptions,
            "joints": self._joints,
            "more": max(0, len(states.names) - joints.MOST) if states else 0,
            "topic": self._topic,
            "publishers": self._others[:_MOST_NAMES],
            "movable": bool(self._source) or self._repeating is not None,
            "publishing": self._repeating is not None,
            "problem": self._repeating.problem if self._repeating else "",
        }

    def _all_descriptions(self) -> list[str]:
        names = (name for name in self.robot.master.get_param_names() if name.endswith(_PARAMETER))
        return sorted(filter(self.robot.access.may_see, names))[:_MOST_NAMES]

    def _arrived(self, arrival: Arrival) -> None:
        try:
            message: Any = arrival.usual
            pairs = [each for each in zip(message.name, message.position, strict=False) if math.isfinite(each[1])]
            with self._lock:
                if self._states is not None:
                    known = self._states.kinds
                    self._heard.update((name, at) for name, at in pairs if name in known)
        except (MessageError, AttributeError, TypeError):
            return  # something else than joint states
