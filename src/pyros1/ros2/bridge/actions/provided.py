"""A ROS 2 action that ROS 1 can use: the bridge calls its server, and provides an action server's topics in ROS 1."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable
from functools import partial

from pyros1.bridge.bridge_publishers import BRIDGE_FIELD, ORIGIN_FIELD
from pyros1.ground.errors import Error, MessageError, ServiceRefusal
from pyros1.ground.names import FullName
from pyros1.ground.terminal_text import one_line
from pyros1.msgs import AnyMsg
from pyros1.node import Node
from pyros1.node.publishing.publisher import Publisher
from pyros1.node.subscribing.subscriber import Subscriber
from pyros1.ros2.bridge.actions import goals_to_ros2 as steps
from pyros1.ros2.bridge.actions import ros1_messages, ros2_messages
from pyros1.ros2.bridge.actions.goals_to_ros2 import GoalsToRos2, Step
from pyros1.ros2.bridge.actions.inbox import Inbox
from pyros1.ros2.bridge.actions.offered import FEEDBACK_QOS, SITE, STATUS_QOS, Warn, _type
from pyros1.ros2.bridge.actions.plan import ProvidedPlan
from pyros1.ros2.bridge.actions.ros1_messages import NO_STAMP, Stamp
from pyros1.ros2.bridge.actions.ros2_messages import UUID_SIZE, GoalInfo
from pyros1.ros2.zenoh.names import DataKey
from pyros1.ros2.zenoh.qos import Qos

RESULT_CALL_TIME = 3600.0
"""Seconds to wait for a result before requesting it again, since a goal may take any amount of time."""
_QUEUE_SIZE = 1000
_GONE = "the action server in ROS 2 is gone"
Reply = bytes | ServiceRefusal
StartCall = Callable[[DataKey, bytes, float, Callable[[Reply], object]], object]
"""Calls a service in ROS 2; see `pyros1.ros2.zenoh.session.Ros2Session.start_call`."""


class ProvidedAction:
    """A ROS 2 action provided in ROS 1. One thread uses `plan` and `close`, the inbox's thread everything else.

    Args:
        node: the bridge's node; it must run callbacks inline.
        plan: the action.
        start_call: calls a ROS 2 service.
        call_time: maximum number of seconds for the server to respond to a goal, or to a cancel request.
        inbox: queues the tasks.
        warn: logs a warning, given its text and an error, for which ``%s`` stands in the text.

    Raises:
        Error: the master refuses a topic, or does not respond.
    """

    def __init__(
        self, node: Node, plan: ProvidedPlan, start_call: StartCall, call_time: float, inbox: Inbox, warn: Warn
    ) -> None:
        self.plan = plan
        self.gone_since: float | None = None
        self._start_call = start_call
        self._call_time = call_time
        self._inbox = inbox
        self._warn = warn
        self._is_gone = False
        self._goals = GoalsToRos2(partial(secrets.token_bytes, UUID_SIZE))
        self._publishers: dict[str, Publisher[AnyMsg]] = {}
        self._subscribers: list[Subscriber[AnyMsg]] = []
        pair = plan.pair
        topics = {
            "result": pair.result,
            "feedback": pair.feedback,
            "status": _type("actionlib_msgs/GoalStatusArray"),
        }
        handlers = {
            "cancel": (_type("actionlib_msgs/GoalID").md5sum, self._on_cancel),
            "goal": (pair.goal.md5sum, self._on_goal),
        }
        try:
            for topic, topic_type in topics.items():
                self._publishers[topic] = node.advertise(
                    FullName(f"{plan.name}/{topic}"),
                    AnyMsg,
                    queue_size=_QUEUE_SIZE,
                    latch=topic == "status",
                    headers={BRIDGE_FIELD: SITE, ORIGIN_FIELD: f"{SITE}:{plan.node}"},
                    raw_type=topic_type,
                )
            for topic, (md5sum, handler) in handlers.items():
                callback = partial(self._on_ros1, md5sum, handler)
                self._subscribers.append(
                    node.subscribe(FullName(f"{plan.name}/{topic}"), AnyMsg, callback, queue_size=_QUEUE_SIZE)
                )
        except BaseException:
            self.close()
            raise

    @property
    def subscribers(self) -> dict[DataKey, Qos]:
        """The keys to which a session subscribes, each with its QoS."""
        return {self.plan.keys.feedback: FEEDBACK_QOS, self.plan.keys.status: STATUS_QOS}

    # Messages from ROS 1 ----------------------------------------------------------------------------------------------

    def _on_ros1(self, md5sum: str, handler: Callable[[bytes], object], message: AnyMsg) -> None:
        """Handle a message from a client. Called on the node's threads."""
        if (message._connection_header or {}).get("md5sum") == md5sum:
            self._inbox.put(partial(self._handle, handler, message._buff), len(message._buff))

    def _handle(self, handler: Callable[[bytes], object], body: bytes) -> None:
        try:
            handler(body)
        except MessageError as error:
            self._warn(f"cannot use a message of the action {self.plan.name}: %s", error)

    def _on_goal(self, body: bytes) -> None:
        name, stamp, goal = ros1_messages.decode_goal(body)
        now = time.monotonic()
        self._do(self._goals.on_goal(name, stamp, goal, now, _ros_now()))
        if self._is_gone:
            self._do(self._goals.on_lost(_GONE, now))

    def _on_cancel(self, body: bytes) -> None:
        self._do(self._goals.on_cancel(*ros1_messages.decode_cancel(body), time.monotonic()))

    # Messages from ROS 2 ----------------------------------------------------------------------------------------------

    def on_ros2(self, key: DataKey, body: bytes) -> None:
        """Handle feedback or statuses from the server."""
        self._handle(self._on_feedback if key == self.plan.keys.feedback else self._on_statuses, body)

    def _on_feedback(self, body: bytes) -> None:
        data = self.plan.pair.to_feedback.from_cdr(body)
        self._do(self._goals.on_feedback(data[:UUID_SIZE], data[UUID_SIZE:]))

    def _on_statuses(self, body: bytes) -> None:
        self._do(self._goals.on_statuses(ros2_messages.decode_statuses(body), time.monotonic()))

    def _on_goal_reply(self, uuid: bytes, reply: Reply) -> None:
        accepted, text = None, ""
        try:
            accepted, _ = ros2_messages.decode_goal_response(_body_of(reply))
        except Error as error:
            text = _text_of(error)
        self._do(self._goals.on_goal_response(uuid, accepted, text, time.monotonic()))

    def _on_result_reply(self, uuid: bytes, reply: Reply) -> None:
        status, result, text = None, b"", ""
        try:
            data = self.plan.pair.to_result.from_cdr(_body_of(reply))
            status, result = int.from_bytes(data[:1], "little", signed=True), data[1:]
        except MessageError as error:
            status, text = 0, _text_of(error)
            self._warn(f"cannot use a result of the action {self.plan.name}: %s", error)
        except ServiceRefusal as error:
            text = _text_of(error)
        self._do(self._goals.on_result(uuid, status, result, text, time.monotonic()))

    def _on_cancel_reply(self, uuid: bytes, reply: Reply) -> None:
        goals: list[GoalInfo] = []
        try:
            _, goals = ros2_messages.decode_cancel_response(_body_of(reply))
        except Error as error:
            self._warn(f"the action {self.plan.name} in ROS 2 did not respond to a request to cancel a goal: %s", error)
        self._do(self._goals.on_cancel_response(uuid, goals, time.monotonic()))

    def tick(self) -> None:
        """Perform the actions that are due."""
        self._do(self._goals.tick(time.monotonic()))

    def on_lost(self) -> None:
        """End all goals, since the server is gone."""
        self._is_gone = True
        self._do(self._goals.on_lost(_GONE, time.monotonic()))

    def on_found(self) -> None:
        """Accept goals again, since the server is back."""
        self._is_gone = False

    def end(self) -> None:
        """End all goals, since the bridge is shutting down."""
        self._do(self._goals.on_lost("the bridge to ROS 2 is shutting down", time.monotonic()))

    # Effects ----------------------------------------------------------------------------------------------------------

    def _do(self, todo: list[Step]) -> None:
        for step in todo:
            try:
                self._do_one(step)
            except Error as error:
                self._warn(f"action {self.plan.name}: %s", error)

    def _do_one(self, step: Step) -> None:
        keys, pair = self.plan.keys, self.plan.pair
        match step:
            case steps.CallGoal(uuid, goal):
                try:
                    body = pair.to_goal.to_cdr(uuid + goal)
                except MessageError as error:
                    self._do(self._goals.on_goal_response(uuid, False, _text_of(error), time.monotonic()))
                    return
                self._call(keys.send_goal, body, self._call_time, partial(self._on_goal_reply, uuid))
            case steps.CallResult(uuid):
                body = ros2_messages.encode_uuid(uuid)
                self._call(keys.get_result, body, RESULT_CALL_TIME, partial(self._on_result_reply, uuid))
            case steps.CallCancel(uuid):
                body = ros2_messages.encode_cancel(GoalInfo(uuid, NO_STAMP))
                self._call(keys.cancel_goal, body, self._call_time, partial(self._on_cancel_reply, uuid))
            case steps.PublishResult(status, result):
                body = ros1_messages.encode_result(_ros_now(), status, pair.empty_result if result is None else result)
                self._publishers["result"].publish(AnyMsg(body))
            case steps.PublishFeedback(status, feedback):
                self._publishers["feedback"].publish(AnyMsg(ros1_messages.encode_result(_ros_now(), status, feedback)))
            case steps.PublishStatuses(statuses):
                self._publishers["status"].publish(AnyMsg(ros1_messages.encode_statuses(_ros_now(), statuses)))

    def _call(self, key: DataKey, body: bytes, timeout: float, done: Callable[[Reply], object]) -> None:
        def put(reply: Reply) -> None:
            self._inbox.put(partial(done, reply), len(reply) if isinstance(reply, bytes) else 0, is_due=True)

        try:
            self._start_call(key, body, timeout, put)
        except ServiceRefusal as error:
            put(error)

    def close(self) -> None:
        """Leave the ROS 1 topics. This waits for the master."""
        for subscriber in self._subscribers:
            subscriber.unregister()
        for publisher in self._publishers.values():
            publisher.unregister()


def _body_of(reply: Reply) -> bytes:
    if isinstance(reply, ServiceRefusal):
        raise reply
    return reply


def _text_of(error: Error) -> str:
    return one_line(str(error.args[0]) if error.args else str(error), 300)


def _ros_now() -> Stamp:
    seconds, nanoseconds = divmod(time.time_ns(), 1_000_000_000)
    return seconds, nanoseconds
