"""A ROS 2 program with an action server and an action client, written with zenoh-ros2-sdk.

The SDK has no actions of its own, but all that they consist of: three services and two topics. `python
ros2_sdk_actions_peer.py PORT` serves ``/ros2_test`` of type actionlib/action/Test: it accepts goals that are not
negative, sends 1, 2, ... as feedback up to the goal, five per second, and then the goal as the result. A line
``goal 5`` of its input sends a goal to ``/ros1_test``, and ``cancel 5`` cancels it after the first feedback; it prints
what comes.
"""

from __future__ import annotations

import queue
import sys
import threading
import time
import uuid
from typing import Any

import numpy
import zenoh_ros2_sdk as sdk
from zenoh_ros2_sdk.qos import QosDurability, QosProfile

from pyros1.ros2.bridge.actions.pairs import ActionHashes
from pyros1.ros2.pairs.type_pairs import TypePairs

TYPE = "actionlib/action/Test"
UUID = "uint8[16] goal_id\n"
INFO = UUID + "int32 sec\nuint32 nanosec\n"  # action_msgs/msg/GoalInfo without what is nested
SEND_GOAL = (UUID + "int32 goal\n", "bool accepted\nint32 sec\nuint32 nanosec\n")
GET_RESULT = (UUID, "int8 status\nint32 result\n")
CANCEL = (INFO, "int8 return_code\nuint32 count\nuint8[16] goal_id\nint32 sec\nuint32 nanosec\n")  # of one goal
FEEDBACK = UUID + "int32 feedback\n"
STATUS = "uint32 count\n" + INFO + "int8 status\n"  # of one goal
EXECUTING, CANCELING, SUCCEEDED, CANCELED = 2, 3, 4, 5


class Types:
    """The types of an action's services and topics, each with a name of its own, since the SDK knows each name once."""

    def __init__(self, hashes: ActionHashes, router: dict[str, Any]) -> None:
        self.hashes, self.router = hashes, router

    def service(self, kind: str, name: str, part: str, **how: Any) -> Any:
        """Return a server or a client."""
        types = {
            "send_goal": (f"{TYPE}_SendGoal", SEND_GOAL),
            "get_result": (f"{TYPE}_GetResult", GET_RESULT),
            "cancel_goal": ("action_msgs/srv/CancelGoal", CANCEL),
        }
        type_name, (request, response) = types[part]
        make = sdk.ROS2ServiceServer if kind == "server" else sdk.ROS2ServiceClient
        return make(
            f"{name}/_action/{part}",
            type_name,
            request_definition=request,
            response_definition=response,
            type_hash=getattr(self.hashes, part),
            node_name=f"sdk_action_{kind}",
            **how,
            **self.router,
        )


class Server:
    """The action server."""

    def __init__(self, types: Types) -> None:
        self.goals: dict[bytes, dict[str, Any]] = {}
        self.send, self.result, self.cancel = (
            types.service("server", "/ros2_test", part, mode="queue")
            for part in ("send_goal", "get_result", "cancel_goal")
        )
        where = {"node_name": "sdk_action_server", **types.router}
        latched = QosProfile(durability=QosDurability.TRANSIENT_LOCAL, history_depth=1)
        self.feedback = sdk.ROS2Publisher(
            "/ros2_test/_action/feedback",
            f"{TYPE}_FeedbackMessage",
            msg_definition=FEEDBACK,
            type_hash=types.hashes.feedback,
            **where,
        )
        self.status = sdk.ROS2Publisher(
            "/ros2_test/_action/status",
            "action_msgs/msg/GoalStatusArray",
            msg_definition=STATUS,
            type_hash=types.hashes.status,
            qos=latched,
            **where,
        )
        for take in (self.take_goals, self.take_results, self.take_cancels):
            threading.Thread(target=take, daemon=True).start()

    def report(self, goal_id: bytes, status: int) -> None:
        """Publish the status of a goal."""
        self.goals[goal_id]["status"] = status
        self.status.publish(count=1, goal_id=array(goal_id), sec=1, nanosec=0, status=status)

    def take_goals(self) -> None:
        """Accept goals, or do not."""
        while True:
            key, request = self.send.take_request()
            goal_id, accepted = bytes(request.goal_id), request.goal >= 0
            print("server got", request.goal, flush=True)
            self.goals[goal_id] = {"status": EXECUTING, "ended": threading.Event(), "result": 0}
            self.send.send_response(key, self.send.response_msg_class(accepted=accepted, sec=1, nanosec=0))
            if accepted:
                threading.Thread(target=self.execute, args=(goal_id, request.goal), daemon=True).start()

    def execute(self, goal_id: bytes, number: int) -> None:
        """Count, as long as nobody cancels."""
        self.report(goal_id, EXECUTING)
        goal = self.goals[goal_id]
        for step in range(1, number + 1):
            time.sleep(0.2)
            goal["result"] = step
            if goal["status"] == CANCELING:
                break
            self.feedback.publish(goal_id=array(goal_id), feedback=step)
        self.report(goal_id, CANCELED if goal["status"] == CANCELING else SUCCEEDED)
        goal["ended"].set()

    def take_results(self) -> None:
        """Answer requests for results when the goals have ended."""
        while True:
            key, request = self.result.take_request()
            threading.Thread(target=self.answer, args=(key, self.goals[bytes(request.goal_id)]), daemon=True).start()

    def answer(self, key: Any, goal: dict[str, Any]) -> None:
        """Answer one."""
        goal["ended"].wait()
        response = self.result.response_msg_class(status=goal["status"], result=goal["result"])
        self.result.send_response(key, response)

    def take_cancels(self) -> None:
        """Cancel goals."""
        while True:
            key, request = self.cancel.take_request()
            self.report(bytes(request.goal_id), CANCELING)
            self.cancel.send_response(
                key,
                self.cancel.response_msg_class(return_code=0, count=1, goal_id=request.goal_id, sec=1, nanosec=0),
            )


class Client:
    """The action client."""

    def __init__(self, types: Types) -> None:
        self.send, self.result, self.cancel = (
            types.service("client", "/ros1_test", part, timeout=5.0)
            for part in ("send_goal", "get_result", "cancel_goal")
        )
        self.steps: queue.Queue[tuple[bytes, int]] = queue.Queue()
        self.feedback = sdk.ROS2Subscriber(
            "/ros1_test/_action/feedback",
            f"{TYPE}_FeedbackMessage",
            lambda message: self.steps.put((bytes(message.goal_id), message.feedback)),
            msg_definition=FEEDBACK,
            type_hash=types.hashes.feedback,
            node_name="sdk_action_client",
            **types.router,
        )

    def run(self, number: int, cancels: bool) -> None:
        """Send a goal, and print what comes."""
        goal_id = uuid.uuid4().bytes
        response = self.send.call(goal_id=array(goal_id), goal=number)
        if response is None or not response.accepted:
            print("client not accepted", number, flush=True)
            return
        of, step = self.steps.get(timeout=10.0)
        print("client feedback", of == goal_id, step, flush=True)
        if cancels:
            response = self.cancel.call(goal_id=array(goal_id), sec=0, nanosec=0)
            print("client cancels", response.return_code, bytes(response.goal_id) == goal_id, flush=True)
        result = self.result.call(goal_id=array(goal_id))
        print("client result", result.status, result.result, flush=True)


def array(data: bytes) -> Any:
    """Return bytes as the SDK takes them."""
    return numpy.frombuffer(data, dtype=numpy.uint8)


def main() -> None:
    """Run until the input ends."""
    hashes = TypePairs().actions.for_ros1("actionlib/Test", {}).hashes
    types = Types(hashes, {"router_ip": "127.0.0.1", "router_port": int(sys.argv[1])})
    Server(types)
    client = Client(types)
    print("ready", flush=True)
    for line in sys.stdin:
        word, number = line.split()
        client.run(int(number), word == "cancel")


if __name__ == "__main__":
    main()
