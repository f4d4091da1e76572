"""Shows a robot's joints with their limits and positions, and moves them."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error, MessageError, ParameterNotSetError
from pyros1.urdf.joints import JointStates
from pyros1.urdf.reading import read_robot
from pyros1.web.models import joints
from pyros1.web.models.repeated_publisher import RepeatedPublisher
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.view import View, string_arg

if TYPE_CHECKING:
    from pyros1.web.hub import Arrival
    from pyros1.web.robot import Robot

_DEFAULT_DESCRIPTION = "/robot_description"
_REFRESH_PERIOD = 1.0
"""Seconds between checks for changes to the description and the publishers."""
_MESSAGES_PER_SECOND = 10.0
_JOINT_STATE_TYPE = "sensor_msgs/JointState"
_MAX_NAMES = 50


class _PublishedElsewhereError(RequestError):
    """Another view is already publishing the joints."""


class JointsView(View):
    """Displays and moves the joints of a robot description.

    A node that publishes the joints keeps doing so, and is sent the desired positions: on the topic ``~sliders`` of
    pyros1's joint_state_publisher, or on a topic in the source_list of other publishers. If no node publishes the
    joints, this view can. If several views are opened to publish the joints, only the first one does; when the first is
    closed, another takes over.

    Args (sent by the page):
        description: name of the parameter with the robot description. The joints' topic is joint_states, in the same
            namespace.
        publish: whether to publish the joints while this view is open, if no other node does.
        positions: joint -> desired position in radians or metres. To move joints, the page changes this argument.

    Pushes ``{"facts": {...}, "positions": [...]}``, each only when it has changed. The facts are described at `_facts`;
    positions are in the order of the joints, with null for unknown positions.
    """

    period = 1 / 15
    polls_periodically = True

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self._description = string_arg(args, "description", _DEFAULT_DESCRIPTION)
        self._topic = f"{self._description.rpartition('/')[0]}/joint_states"
        robot.check_visible(self._description)
        self._lock = threading.Lock()  # guards the states and the received messages
        self._positions: dict[str, float] = {}
        self._states: JointStates | None = None
        self._problem = ""
        self._joints: list[dict[str, Any]] = []
        self._descriptions: list[str] = []
        self._last_read: Any = None  # the description and the publishers when they were last read
        self._other_publishers: list[str] = []
        self._position_topics: list[tuple[str, str]] = []
        self._position_topic = ""
        self._refreshed_at = float("-inf")
        self._last_pushed: dict[str, Any] = {}
        self._publisher: RepeatedPublisher | None = None
        self._unsubscribe = robot.listen(self._topic, self._on_joint_states)
        self._deferred_args: Mapping[str, Any] | None = None  # applied when another view stops publishing
        try:
            self._apply_args(args)
        except _PublishedElsewhereError:
            # The other view may belong to this page's previous connection, if that has not been closed yet.
            self._deferred_args = args
        except BaseException:
            self.close()
            raise

    def poll(self) -> Push | None:
        if monotonic() - self._refreshed_at >= _REFRESH_PERIOD:
            self._refresh()
            if self._deferred_args is not None:
                with suppress(_PublishedElsewhereError):
                    self._apply_args(self._deferred_args)
                    self._deferred_args = None
        if self._problem:
            raise RequestError(self._problem)
        current: dict[str, Any] = {"facts": self._facts()}
        with self._lock:
            current["positions"] = [self._positions.get(joint["name"]) for joint in self._joints]
        changed = {key: value for key, value in current.items() if value != self._last_pushed.get(key)}
        self._last_pushed = current
        return Push(changed) if changed else None

    def change(self, args: Mapping[str, Any]) -> None:
        self._deferred_args = None
        self._apply_args(args)

    def close(self) -> None:
        self._unsubscribe()
        self._stop_publishing()

    def _apply_args(self, args: Mapping[str, Any]) -> None:
        positions, publish = joints.check_positions(args.get("positions", {})), bool(args.get("publish"))
        if not positions and not publish:
            self._stop_publishing()
            return
        if self.robot.access.read_only:
            raise RequestError("this server is read-only (--read-only)")
        self._refresh()
        publishing_view = self.robot.joint_publishers.get(self._topic, self)
        if publish and not self._other_publishers:
            publishing_view = self.robot.joint_publishers.setdefault(self._topic, self)
        # This detects another view even if the master does not list its publisher yet.
        if publish and publishing_view is not self:
            raise _PublishedElsewhereError(f"another page is already publishing {self._topic}")
        if publish and not self._other_publishers:
            with self._lock:
                if self._states is not None:
                    self._states.apply(list(positions), list(positions.values()))
            if self._publisher is None:
                self._publisher = RepeatedPublisher(self._publish, _MESSAGES_PER_SECOND)
        elif positions:
            self._move(positions)

    def _move(self, positions: Mapping[str, float]) -> None:
        if not self._position_topic:
            raise RequestError(f"no node subscribes to {self._topic}")
        value = {"header": {"stamp": "now"}, "name": list(positions), "position": list(positions.values())}
        self.robot.publishers.publish(self._position_topic, _JOINT_STATE_TYPE, value)

    def _publish(self) -> int:
        with self._lock:
            if self._states is None:
                return 0
            names, positions, velocities, efforts = self._states.message_fields()
        numbers = {"position": positions, "velocity": velocities, "effort": efforts}
        value = {"header": {"stamp": "now"}, "name": names, **numbers}
        return self.robot.publishers.publish(self._topic, _JOINT_STATE_TYPE, value)

    def _stop_publishing(self) -> None:
        if self._publisher is not None:
            self._publisher.close()
            self._publisher = None
            self.robot.publishers.unadvertise(self._topic)
        if self.robot.joint_publishers.get(self._topic) is self:
            del self.robot.joint_publishers[self._topic]

    def _refresh(self) -> None:
        """Check for changes to the description and the publishers."""
        self._refreshed_at = monotonic()
        node = self.robot.node
        description = node.params.cached(self._description)
        state = self.robot.graph.state()
        # If another view publishes the joints, the node's publisher belongs to that view.
        own_name = node.name if self.robot.joint_publishers.get(self._topic, self) is self else ""
        self._other_publishers = sorted(name for name in state.publishers.get(self._topic, []) if name != own_name)
        if (description, self._other_publishers) != self._last_read:
            self._last_read = (description, self._other_publishers)
            self._read_description(description)
        self._descriptions = [] if self._states else self._all_descriptions()
        accepted = (topic for name, topic in self._position_topics if name in state.subscribers.get(topic, []))
        self._position_topic = next((topic for topic in accepted if self.robot.access.may_see(topic)), "")
        if self._other_publishers:
            self._stop_publishing()  # another node, such as the robot's driver, has started to publish the joints

    def _read_description(self, description: Any) -> None:
        params = {name: self._private_params(name) for name in self._other_publishers[:_MAX_NAMES]}
        self._position_topics = [
            (name, topic) for name, values in params.items() for topic in joints.position_topics(name, values)
        ]
        states, self._problem = None, ""
        if isinstance(description, str):
            try:
                states = JointStates(read_robot(description), joints.publisher_options(next(iter(params.values()), {})))
            except Error as error:
                self._problem = f"{self._description}: {error}"
        with self._lock:
            self._states, self._positions = states, {}
            self._joints = joints.describe(states) if states else []

    def _private_params(self, node: str) -> Any:
        try:
            return self.robot.master.get_param(f"{node}/")
        except ParameterNotSetError:
            return {}

    def _facts(self) -> dict[str, Any]:
        """Return the data that the page displays, except for positions.

        ``description``: name of the parameter; ``there``: whether it contains a robot description; if not,
        ``descriptions``: the names of all that exist. ``joints``: see `pyros1.web.models.joints.describe`;
        ``more``: number of joints that are omitted. ``topic``, ``publishers``: where the joints' states come from.
        ``movable``: whether joints can be moved. ``publishing``: whether this view publishes the joints;
        ``problem``: why it cannot.
        """
        states = self._states
        return {
            "description": self._description,
            "there": states is not None,
            "descriptions": self._descriptions,
            "joints": self._joints,
            "more": max(0, len(states.names) - joints.MAX_JOINTS) if states else 0,
            "topic": self._topic,
            "publishers": self._other_publishers[:_MAX_NAMES],
            "movable": bool(self._position_topic) or self._publisher is not None,
            "publishing": self._publisher is not None,
            "problem": self._publisher.problem if self._publisher else "",
        }

    def _all_descriptions(self) -> list[str]:
        names = (name for name in self.robot.master.get_param_names() if name.endswith(_DEFAULT_DESCRIPTION))
        return sorted(filter(self.robot.access.may_see, names))[:_MAX_NAMES]

    def _on_joint_states(self, arrival: Arrival) -> None:
        try:
            message: Any = arrival.checked_message
            pairs = [pair for pair in zip(message.name, message.position, strict=False) if math.isfinite(pair[1])]
            with self._lock:
                if self._states is not None:
                    joint_types = self._states.joint_types
                    self._positions.update((name, position) for name, position in pairs if name in joint_types)
        except (MessageError, AttributeError, TypeError):
            return  # the message does not contain joint states
