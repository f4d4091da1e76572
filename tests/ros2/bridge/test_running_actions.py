"""Actions that a running bridge to ROS 2 exchanges.

Feature: actions of ROS 2 nodes that use rmw_zenoh -- `pyros1 bridge ros2`, both ways
"""

from __future__ import annotations

import json
import queue
import struct
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("zenoh")

from pyros1.actions import Client, GoalError, Server, ServerGoal, SimpleServer, Status
from pyros1.bridge.status import status_lines
from pyros1.ground.errors import ServiceRefusal
from pyros1.msgs import load_message
from pyros1.ros2.bridge.actions import ros2_messages
from pyros1.ros2.bridge.actions.plan import ActionKeys, action_keys
from pyros1.ros2.bridge.actions.ros2_messages import NO_UUID, CancelCode, GoalInfo, ReportedGoal, Ros2Status
from pyros1.ros2.bridge.rules import Ros2Rules
from pyros1.ros2.pairs.type_pairs import TypePairs
from pyros1.ros2.zenoh.calls import IncomingCall
from pyros1.ros2.zenoh.qos import Qos

from ...bridge.conftest import PATIENCE, wait_until
from .test_running import Ros2Peer, RunningBridge, endpoint

__all__ = ["endpoint"]

FIBONACCI = "actionlib_tutorials/Fibonacci"
NAME = "/fibonacci"
CALL_TIME = 20.0
HEAD = b"\0\1\0\0"
UUID = bytes(range(1, 17))


def keys(name: str = NAME) -> ActionKeys:
    return action_keys(0, name, TypePairs().actions.for_ros1(FIBONACCI, {}))


def numbers(*values: int) -> bytes:
    return struct.pack(f"<I{len(values)}i", len(values), *values)


class ActionPeer(Ros2Peer):
    """A ROS 2 node that has an action client and server."""

    def use(self, action: ActionKeys) -> None:
        """Become a client."""
        for key in action.services:
            self._clients.append(key)
        self._subscribes |= {action.feedback: Qos(), action.status: Qos(transient_local=True, depth=1)}
        self._declare()
        self.action = action
        wait_until(lambda: all(self.graph.service(key.name).servers for key in action.services), "ROS 2 sees services")
        wait_until(lambda: all(self.graph.topic(key.name).publishers for key in action[3:]), "ROS 2 sees topics")

    def serve(self, action: ActionKeys) -> None:
        """Become a server."""
        self.action = action
        self._offers += action.services
        self.publish(action.feedback)
        self.publish(action.status, Qos(transient_local=True, depth=1))

    def stop(self) -> None:
        """Be no server any longer."""
        self._offers.clear()
        self._publishes.clear()
        self._declare()

    def send_goal(self, uuid: bytes, order: int) -> bool:
        body = HEAD + uuid + struct.pack("<i", order)
        return ros2_messages.decode_goal_response(self.session.call(self.action.send_goal, body, CALL_TIME))[0]

    def start_result(self, uuid: bytes) -> queue.Queue[Any]:
        replies: queue.Queue[Any] = queue.Queue()
        self.session.start_call(self.action.get_result, ros2_messages.encode_uuid(uuid), CALL_TIME, replies.put)
        return replies

    def result(self, uuid: bytes) -> tuple[int, list[int]]:
        return decode_result(self.start_result(uuid).get(timeout=PATIENCE))

    def cancel(self, info: GoalInfo) -> tuple[int, list[GoalInfo]]:
        reply = self.session.call(self.action.cancel_goal, ros2_messages.encode_cancel(info), CALL_TIME)
        return ros2_messages.decode_cancel_response(reply)

    def await_message(self, name: str, is_wanted: Callable[[bytes], bool]) -> bytes:
        while True:
            got, body = self.get()
            if got == name and is_wanted(body):
                return body

    def await_status(self, uuid: bytes, status: int) -> None:
        def is_wanted(body: bytes) -> bool:
            return any(each.info.uuid == uuid and each.status == status for each in ros2_messages.decode_statuses(body))

        self.await_message(self.action.status.name, is_wanted)

    def asked(self, part: str) -> IncomingCall:
        """Return the next call, which must be of a certain service."""
        call = self.calls.get(timeout=PATIENCE)
        assert call.key == getattr(self.action, part)
        return call

    def accept(self, accepted: bool = True) -> tuple[bytes, int]:
        """Answer the next goal, and return it."""
        call = self.asked("send_goal")
        call.respond(ros2_messages.encode_goal_response(accepted, (1, 2)))
        return call.body[4:20], struct.unpack("<i", call.body[20:])[0]

    def report(self, uuid: bytes, status: int) -> None:
        self.send(self.action.status, ros2_messages.encode_statuses([ReportedGoal(GoalInfo(uuid, (1, 2)), status)]))


def result(status: int, *values: int) -> bytes:
    return HEAD + struct.pack("<b3x", status) + numbers(*values)


def decode_result(reply: Any) -> tuple[int, list[int]]:
    assert isinstance(reply, bytes), reply
    (length,) = struct.unpack_from("<I", reply, 8)
    return reply[4], [*struct.unpack_from(f"<{length}i", reply, 12)]


@pytest.fixture
def bridge(endpoint: str, tmp_path: Path) -> Iterator[RunningBridge]:
    running = RunningBridge(tmp_path, listen=[endpoint])
    yield running
    running.close()


@pytest.fixture
def peer(bridge: RunningBridge, endpoint: str) -> Iterator[ActionPeer]:
    peer = ActionPeer(endpoint)
    yield peer
    peer.session.close()


class Fibonacci:
    """An action server in ROS 1 whose goals the test ends."""

    def __init__(self, bridge: RunningBridge, name: str = NAME) -> None:
        self.goals: queue.Queue[ServerGoal] = queue.Queue()
        self.server = Server(bridge.node, name, FIBONACCI, self.goals.put)

    def __enter__(self) -> Fibonacci:
        return self

    def __exit__(self, *_: object) -> None:
        self.server.close()

    def get(self) -> ServerGoal:
        return self.goals.get(timeout=PATIENCE)


def send(client: Client, order: int, **callbacks: Any) -> Any:
    return client.send(client.types.goal(order=order), **callbacks)


def values(goal: Any) -> list[int]:
    """Return the result of a goal that has ended, however it has."""
    try:
        return [*goal.outcome().sequence]
    except GoalError as error:
        return [*error.result.sequence]


def start(function: Callable[[], Any]) -> Callable[[], Any]:
    """Call a function in a thread, and return what waits for what it returns."""
    results: queue.Queue[Any] = queue.Queue()
    threading.Thread(target=lambda: results.put(function())).start()
    return lambda: results.get(timeout=PATIENCE)


def test_ros2_uses_an_action_of_ros1(bridge: RunningBridge, peer: ActionPeer) -> None:
    with Fibonacci(bridge) as server:
        peer.use(keys())
        accepted = start(lambda: peer.send_goal(UUID, 5))
        goal = server.get()
        assert goal.goal.order == 5 and goal.name == UUID.hex()
        goal.accept()
        assert accepted() is True
        peer.await_status(UUID, Ros2Status.EXECUTING)
        later = peer.start_result(UUID)
        goal.feedback(server.server.types.feedback(sequence=[0, 1]))
        feedback = peer.await_message(peer.action.feedback.name, lambda body: True)
        assert feedback == HEAD + UUID + numbers(0, 1)
        assert later.empty()
        goal.succeed(server.server.types.result(sequence=[0, 1, 1]))
        assert decode_result(later.get(timeout=PATIENCE)) == (Ros2Status.SUCCEEDED, [0, 1, 1])
        assert peer.result(UUID) == (Ros2Status.SUCCEEDED, [0, 1, 1]), "it is kept"
        peer.await_status(UUID, Ros2Status.SUCCEEDED)
        (row,) = bridge.status()["actions"]
        assert row == {
            "action": NAME,
            "server": "ROS 1",
            "node": "/user",
            "type": "actionlib_tutorials/action/Fibonacci",
        }
        line = "    /fibonacci (actionlib_tutorials/action/Fibonacci): server /user in ROS 1"
        assert line in [*status_lines(bridge.status())]
        topics = {each["topic"] for each in bridge.status()["sent"]}
        assert not {topic for topic in topics if topic.startswith(NAME)}, "no topic of it is exchanged as such"
        assert peer.result(bytes(15) + b"\1") == (Ros2Status.UNKNOWN, [])


def test_goals_of_ros2_that_ros1_rejects_or_aborts(bridge: RunningBridge, peer: ActionPeer) -> None:
    with Fibonacci(bridge) as server:
        peer.use(keys())
        accepted = start(lambda: peer.send_goal(UUID, 5))
        server.get().reject(text="not now")
        assert accepted() is False
        assert peer.send_goal(UUID, 6) is False, "the server knows this id already"
        other = UUID[::-1]
        accepted = start(lambda: peer.send_goal(other, 7))
        goal = server.get()
        goal.accept()
        assert accepted() is True
        assert peer.send_goal(other, 8) is False, "it is the id of another goal"
        goal.abort(server.server.types.result(sequence=[7]))
        assert peer.result(other) == (Ros2Status.ABORTED, [7])


def test_ros2_cancels_a_goal_in_ros1(bridge: RunningBridge, peer: ActionPeer) -> None:
    with Fibonacci(bridge) as server:
        peer.use(keys())
        accepted = start(lambda: peer.send_goal(UUID, 5))
        goal = server.get()
        goal.accept()
        assert accepted() is True
        assert peer.cancel(GoalInfo(bytes(15) + b"\1")) == (CancelCode.UNKNOWN_GOAL, [])
        code, goals = peer.cancel(GoalInfo(UUID))
        assert code == CancelCode.NONE and [each.uuid for each in goals] == [UUID]
        wait_until(lambda: goal.cancel_requested, "the server hears of it")
        peer.await_status(UUID, Ros2Status.CANCELING)
        goal.cancel(server.server.types.result(sequence=[1]))
        assert peer.result(UUID) == (Ros2Status.CANCELED, [1])
        assert peer.cancel(GoalInfo(UUID)) == (CancelCode.ENDED, [])


def test_ros2_cancels_goals_of_ros1s_own_clients(bridge: RunningBridge, peer: ActionPeer) -> None:
    with Fibonacci(bridge) as server, Client(bridge.node, NAME, FIBONACCI) as client:
        peer.use(keys())
        assert client.wait_for_server(PATIENCE)
        send(client, 3)
        goal = server.get()
        goal.accept()

        def cancel() -> bool:
            code, goals = peer.cancel(GoalInfo(NO_UUID))
            return code == CancelCode.NONE and len(goals) == 1

        wait_until(cancel, "ROS 2 sees it")
        wait_until(lambda: goal.cancel_requested, "the server hears of it")


def test_a_goal_of_ros2_preempts_the_one_before(bridge: RunningBridge, peer: ActionPeer) -> None:
    def execute(goal: ServerGoal) -> Any:
        if goal.goal.order:
            wait_until(lambda: goal.cancel_requested, "another goal comes")
            goal.cancel()
            return None
        return load_message("actionlib_tutorials/FibonacciResult")(sequence=[8])

    server = SimpleServer(bridge.node, NAME, FIBONACCI, execute)
    try:
        peer.use(keys())
        assert peer.send_goal(UUID, 1) is True
        later = peer.start_result(UUID)
        other = UUID[::-1]
        assert peer.send_goal(other, 0) is True
        assert decode_result(later.get(timeout=PATIENCE)) == (Ros2Status.CANCELED, [])
        assert peer.result(other) == (Ros2Status.SUCCEEDED, [8])
    finally:
        server.close()


def test_a_server_in_ros1_that_ends_and_starts_again(bridge: RunningBridge, peer: ActionPeer) -> None:
    with Fibonacci(bridge) as server:
        peer.use(keys())
        accepted = start(lambda: peer.send_goal(UUID, 5))
        server.get().accept()
        assert accepted() is True
        later = peer.start_result(UUID)
    assert decode_result(later.get(timeout=PATIENCE)) == (Ros2Status.ABORTED, [])
    wait_until(lambda: not peer.graph.service(peer.action.send_goal.name).servers, "it is gone in ROS 2")
    with Fibonacci(bridge) as server:
        peer.use(keys())
        accepted = start(lambda: peer.send_goal(UUID, 6))
        server.get().accept()
        assert accepted() is True


def test_calls_that_make_no_sense(bridge: RunningBridge, peer: ActionPeer) -> None:
    with Fibonacci(bridge) as server:
        peer.use(keys())
        for key in peer.action.services:
            with pytest.raises(ServiceRefusal):
                peer.session.call(key, b"\0\1", CALL_TIME)
        assert peer.send_goal(NO_UUID, 1) is False
        accepted = start(lambda: peer.send_goal(UUID, 5))
        server.get().accept()
        assert accepted() is True


def test_rules_name_the_action(endpoint: str, tmp_path: Path) -> None:
    bridge = RunningBridge(tmp_path, Ros2Rules(["/shown", "/marker"]), listen=[endpoint])
    try:
        peer = ActionPeer(endpoint)
        with Fibonacci(bridge, "/hidden"), Fibonacci(bridge, "/shown"):
            peer.use(keys("/shown"))
            assert [each["action"] for each in bridge.status()["actions"]] == ["/shown"]
            assert not [name for name in peer.graph.topics() if "hidden" in name]
    finally:
        peer.session.close()
        bridge.close()


def test_actions_that_cannot_be_exchanged(bridge: RunningBridge, peer: ActionPeer) -> None:
    action = keys()
    peer.serve(
        action._replace(
            **{part: getattr(action, part)._replace(hash="RIHS01_" + "0" * 64) for part in action._asdict()}
        )
    )
    wait_until(lambda: NAME in bridge.status()["problems"], "the status says why")
    assert "another definition" in bridge.status()["problems"][NAME]
    peer.stop()
    peer.serve(keys("/both"))
    wait_until(lambda: bridge.status()["actions"], "it is provided")
    with Fibonacci(bridge, "/both"):
        wait_until(lambda: "/both" in bridge.status()["problems"], "the status says so")
        assert bridge.status()["problems"]["/both"] == "/user provides it in ROS 1, and /peer in ROS 2"


def test_two_masters_with_ros2_between_them(bridge: RunningBridge, endpoint: str, tmp_path: Path) -> None:
    other = RunningBridge(tmp_path, name="other", connect=[endpoint])
    try:
        with Fibonacci(bridge) as server, Client(other.node, NAME, FIBONACCI) as client:
            assert client.wait_for_server(PATIENCE)
            goal = send(client, 5)
            there = server.get()
            there.accept()
            there.succeed(server.server.types.result(sequence=[5]))
            assert goal.wait(PATIENCE) and goal.status is Status.SUCCEEDED and values(goal) == [5]
    finally:
        other.close()


def test_two_bridges_of_one_master(bridge: RunningBridge, peer: ActionPeer, endpoint: str) -> None:
    second = bridge.make_bridge("another_bridge", "bridge", connect=[endpoint])
    with Fibonacci(bridge) as server:
        peer.use(keys())
        wait_until(lambda: json.loads(second.status())["actions"], "the second one offers it, too")
        assert not [each for each in json.loads(second.status())["actions"] if each["server"] == "ROS 2"]
        accepted = start(lambda: peer.send_goal(UUID, 5))
        server.get().accept()
        assert accepted() is True


def test_requests_for_results_end_with_the_bridge_and_with_the_session(bridge: RunningBridge, peer: ActionPeer) -> None:
    with Fibonacci(bridge) as server:
        peer.use(keys())
        accepted = start(lambda: peer.send_goal(UUID, 5))
        server.get().accept()
        assert accepted() is True
        later = peer.start_result(UUID)
        bridge.bridge.close()
        refusal = later.get(timeout=PATIENCE)
        assert isinstance(refusal, ServiceRefusal)
        assert not [each for each in threading.enumerate() if each.name == "bridge: actions"]
    peer.session.close()
    with pytest.raises(ServiceRefusal):
        peer.start_result(UUID)
