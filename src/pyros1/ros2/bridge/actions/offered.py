"""A ROS 1 action that ROS 2 can use: the bridge is a client of its server, and offers an action's services in ROS 2."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import partial

from pyros1.bridge.bridge_publishers import BRIDGE_FIELD
from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.rules.rules import Priority
from pyros1.ground.errors import Error, MessageError
from pyros1.ground.names import FullName
from pyros1.msgs import AnyMsg, load_message
from pyros1.node import Node
from pyros1.node.publishing.publisher import Publisher
from pyros1.node.subscribing.subscriber import Subscriber
from pyros1.ros2.bridge.actions import goals_to_ros1 as steps
from pyros1.ros2.bridge.actions import ros1_messages, ros2_messages
from pyros1.ros2.bridge.actions.goals_to_ros1 import GoalsToRos1, Step
from pyros1.ros2.bridge.actions.inbox import Inbox
from pyros1.ros2.bridge.actions.plan import OfferedPlan
from pyros1.ros2.bridge.actions.ros1_messages import NO_STAMP
from pyros1.ros2.bridge.side import Call
from pyros1.ros2.zenoh.names import DataKey, data_key
from pyros1.ros2.zenoh.qos import Qos
from pyros1.wire.handshake import TopicType

SITE = "ros2"
FEEDBACK_QOS = Qos()
STATUS_QOS = Qos(transient_local=True, depth=1)
_QUEUE_SIZE = 1000
Warn = Callable[[str, Error], object]


class OfferedAction:
    """A ROS 1 action offered in ROS 2. One thread uses `plan`, `is_connected` and `close`, the inbox's thread
    everything else.

    Args:
        node: the bridge's node; it must run callbacks inline.
        plan: the action.
        send: sends a message to ROS 2.
        inbox: queues the tasks.
        warn: logs a warning, given its text and an error, for which ``%s`` stands in the text.

    Raises:
        Error: the master refuses a topic, or does not respond.
    """

    def __init__(self, node: Node, plan: OfferedPlan, send: Callable[[Send], object], inbox: Inbox, warn: Warn) -> None:
        self.plan = plan
        self._send = send
        self._inbox = inbox
        self._warn = warn
        self._goals = GoalsToRos1()
        self._statuses = ros2_messages.encode_statuses(())
        self._has_status = False
        self._publishers: dict[str, Publisher[AnyMsg]] = {}
        self._subscribers: list[Subscriber[AnyMsg]] = []
        pair, name = plan.pair, plan.local.name
        handlers: dict[str, tuple[str, Callable[[bytes], object]]] = {
            "status": (_type("actionlib_msgs/GoalStatusArray").md5sum, self._on_statuses),
            "feedback": (pair.feedback.md5sum, self._on_feedback),
            "result": (pair.result.md5sum, self._on_result),
        }
        try:
            for topic, topic_type in (("goal", pair.goal), ("cancel", _type("actionlib_msgs/GoalID"))):
                self._publishers[topic] = node.advertise(
                    FullName(f"{name}/{topic}"),
                    AnyMsg,
                    queue_size=_QUEUE_SIZE,
                    headers={BRIDGE_FIELD: SITE},
                    raw_type=topic_type,
                )
            for topic, (md5sum, handler) in handlers.items():
                callback = partial(self._on_message, md5sum, handler)
                self._subscribers.append(
                    node.subscribe(FullName(f"{name}/{topic}"), AnyMsg, callback, queue_size=_QUEUE_SIZE)
                )
        except BaseException:
            self.close()
            raise

    @property
    def is_connected(self) -> bool:
        """Whether the server is connected to our publishers, and has published its status."""
        node = self.plan.local.node
        return self._has_status and all(
            any(link.peer == node for link in each.links) for each in self._publishers.values()
        )

    @property
    def publishers(self) -> dict[str, tuple[DataKey, Qos, Priority]]:
        """The publishers in ROS 2, as a session declares them."""
        keys = self.plan.keys
        return {
            data_key(key): (key, qos, Priority.NORMAL)
            for key, qos in ((keys.feedback, FEEDBACK_QOS), (keys.status, STATUS_QOS))
        }

    # Incoming messages ------------------------------------------------------------------------------------------------

    def _on_message(self, md5sum: str, handler: Callable[[bytes], object], message: AnyMsg) -> None:
        """Handle a message from the server. Called on the node's threads."""
        header: Mapping[str, str] = message._connection_header or {}
        if header.get("md5sum") == md5sum and BRIDGE_FIELD not in header:
            self._inbox.put(partial(self._handle, handler, message._buff), len(message._buff))

    def _handle(self, handler: Callable[[bytes], object], body: bytes) -> None:
        try:
            handler(body)
        except MessageError as error:
            self._warn(f"cannot use a message of the action {self.plan.local.name}: %s", error)

    def _on_statuses(self, body: bytes) -> None:
        statuses = ros1_messages.decode_statuses(body)
        self._has_status = True
        self._do(self._goals.on_statuses(statuses, time.monotonic()))

    def _on_feedback(self, body: bytes) -> None:
        self._do(self._goals.on_feedback(*ros1_messages.decode_result(body), time.monotonic()))

    def _on_result(self, body: bytes) -> None:
        self._do(self._goals.on_result(*ros1_messages.decode_result(body), time.monotonic()))

    def on_call(self, call: Call) -> None:
        """Handle a call from a client in ROS 2."""
        keys = self.plan.keys
        try:
            if call.key == keys.send_goal:
                goal = self.plan.pair.to_goal.from_cdr(call.body)
                size = ros2_messages.UUID_SIZE
                self._do(self._goals.on_goal(call, goal[:size], goal[size:], time.monotonic()))
            elif call.key == keys.get_result:
                self._do(self._goals.on_result_request(call, ros2_messages.decode_uuid(call.body)))
            else:
                self._do(self._goals.on_cancel(call, ros2_messages.decode_cancel(call.body)))
        except MessageError as error:
            call.fail(str(error))
            self._warn(f"cannot use a call of the action {self.plan.local.name}: %s", error)

    def tick(self) -> None:
        """Perform the actions that are due."""
        self._do(self._goals.tick(time.monotonic()))

    def repeat(self) -> None:
        """Send the statuses again, since their publisher may not have existed before."""
        self._send_statuses()

    def on_lost(self) -> None:
        """Answer the clients in ROS 2, since the server is gone."""
        self._do(self._goals.on_lost(time.monotonic()))

    def end(self) -> None:
        """End all calls, since the bridge is shutting down."""
        self._do(self._goals.close())

    # Effects ----------------------------------------------------------------------------------------------------------

    def _do(self, todo: list[Step]) -> None:
        for step in todo:
            try:
                self._do_one(step)
            except Error as error:
                self._warn(f"action {self.plan.local.name}: %s", error)

    def _do_one(self, step: Step) -> None:
        keys, pair = self.plan.keys, self.plan.pair
        match step:
            case steps.SendGoal(name, goal):
                self._publishers["goal"].publish(AnyMsg(ros1_messages.encode_goal(NO_STAMP, name, goal)))
            case steps.SendCancel(name, stamp):
                self._publishers["cancel"].publish(AnyMsg(ros1_messages.encode_cancel(name, stamp)))
            case steps.AnswerGoal(call, accepted, stamp):
                _respond(call, ros2_messages.encode_goal_response(accepted, stamp))
            case steps.AnswerResult(call, status, result):
                _respond(call, self._result(status, result))
            case steps.AnswerCancel(call, code, goals):
                _respond(call, ros2_messages.encode_cancel_response(code, goals))
            case steps.EndWithoutResponse(call, text):
                assert isinstance(call, Call)
                call.fail(text)
            case steps.SendFeedback(uuid, feedback):
                body = pair.to_feedback.to_cdr(uuid + feedback)
                self._send(Send(data_key(keys.feedback), b"", body, Priority.NORMAL))
            case steps.SendStatuses(reported):
                self._statuses = ros2_messages.encode_statuses(reported)
                self._send_statuses()

    def _result(self, status: int, result: bytes | None) -> bytes:
        pair = self.plan.pair
        if result is not None:
            try:
                return pair.to_result.to_cdr(bytes((status,)) + result)
            except MessageError as error:
                self._warn(f"cannot convert a result of the action {self.plan.local.name}: %s", error)
                status = ros2_messages.Ros2Status.ABORTED
        return pair.to_result.to_cdr(bytes((status,)) + pair.empty_result)

    def _send_statuses(self) -> None:
        self._send(Send(data_key(self.plan.keys.status), b"", self._statuses, Priority.NORMAL))

    def close(self) -> None:
        """Leave the ROS 1 topics. This waits for the master."""
        for publisher in self._publishers.values():
            publisher.unregister()
        for subscriber in self._subscribers:
            subscriber.unregister()


def _respond(call: object, body: bytes) -> None:
    assert isinstance(call, Call)
    try:
        call.respond(body)
    except Exception as error:  # noqa: BLE001 - zenoh's, if the session is closed meanwhile
        raise MessageError(f"a call cannot be answered: {error}") from None


def _type(name: str) -> TopicType:
    message_class = load_message(name)
    return TopicType(name, message_class._md5sum, message_class._full_text)
