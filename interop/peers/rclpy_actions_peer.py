"""A ROS 2 program with an action server and an action client, written with rclpy.

`python rclpy_actions_peer.py` serves ``/ros2_fib`` of type test_msgs/action/Fibonacci: five numbers per second; it
aborts goals that are negative. Then it sends two goals to ``/ros1_fib``, of which it cancels the second one after its
first feedback, and prints what comes. It ends with its input.
"""

from __future__ import annotations

import sys
import threading
import time
from typing import Any

import rclpy
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.executors import MultiThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from test_msgs.action import Fibonacci


def execute(goal: Any) -> Any:
    """Compute Fibonacci numbers."""
    numbers = [0, 1]
    for _ in range(goal.request.order):
        time.sleep(0.2)
        if goal.is_cancel_requested:
            goal.canceled()
            return Fibonacci.Result(sequence=numbers)
        numbers.append(numbers[-1] + numbers[-2])
        goal.publish_feedback(Fibonacci.Feedback(sequence=numbers))
    end = goal.abort if goal.request.order < 0 else goal.succeed
    end()
    return Fibonacci.Result(sequence=numbers)


def wait(future: Any) -> Any:
    """Wait for a future, and return its result. The executor runs in another thread."""
    done = threading.Event()
    future.add_done_callback(lambda _: done.set())
    if not done.wait(60.0):
        raise TimeoutError
    return future.result()


def use(client: Any, order: int, cancels: bool) -> None:
    """Send a goal and print what comes."""
    has_feedback = threading.Event()

    def on_feedback(message: Any) -> None:
        print("feedback", *message.feedback.sequence, flush=True)
        has_feedback.set()

    goal = wait(client.send_goal_async(Fibonacci.Goal(order=order), feedback_callback=on_feedback))
    print("accepted", goal.accepted, flush=True)
    result = goal.get_result_async()
    if cancels and has_feedback.wait(60.0):
        print("canceling", len(wait(goal.cancel_goal_async()).goals_canceling), flush=True)
    response = wait(result)
    print("result", response.status, *response.result.sequence, flush=True)


def main() -> None:
    """Run until the input ends."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("actions")
    server = ActionServer(node, Fibonacci, "/ros2_fib", execute, cancel_callback=lambda _: CancelResponse.ACCEPT)
    client = ActionClient(node, Fibonacci, "/ros1_fib")
    executor = MultiThreadedExecutor(4)
    executor.add_node(node)
    threading.Thread(target=executor.spin, daemon=True).start()
    print("ready", flush=True)
    print("found", client.wait_for_server(timeout_sec=60.0), flush=True)
    use(client, 3, cancels=False)
    use(client, 50, cancels=True)
    sys.stdin.read()
    executor.shutdown(0)
    server.destroy()


main()
