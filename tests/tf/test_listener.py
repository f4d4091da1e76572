"""Broadcasters and the listener, on live topics."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.ground.errors import NodeShutdownError
from pyros1.ground.timing import Time
from pyros1.master.server import Master
from pyros1.msgs import load_message
from pyros1.node import Node
from pyros1.node.context import wait_for_links
from pyros1.tf import Buffer, StaticTransformBroadcaster, TransformBroadcaster, TransformListener

from ..parts import publication_of

Make = Callable[..., Node]


def stamped(parent: str, child: str, seconds: float, x: float = 0.0) -> Any:
    message: Any = load_message("geometry_msgs/TransformStamped")()
    message.header.frame_id, message.child_frame_id = parent, child
    message.header.stamp = Time.from_sec(seconds)
    message.transform.translation.x = x
    message.transform.rotation.w = 1.0
    return message


@pytest.mark.parametrize("callbacks", ["inline", "spin"])
def test_transforms_travel(make_node: Make, transport: str, callbacks: str) -> None:
    """In a node that spins, too, a lookup in the main thread gets what comes meanwhile."""
    robot = make_node("robot")
    static = StaticTransformBroadcaster(robot)
    static.send_transform(stamped("base", "lidar", 1, 0.5))
    static.send_transform([stamped("base", "camera", 1, 0.1), stamped("base", "lidar", 1, 0.25)])
    moving = TransformBroadcaster(robot)
    listening = make_node("viewer", callbacks=callbacks)
    buffer = Buffer()
    TransformListener(listening, buffer)
    assert buffer.lookup_transform("base", "lidar", timeout=10).transform.translation.x == 0.25
    assert buffer.lookup_transform("base", "camera", timeout=10).transform.translation.x == 0.1
    assert wait_for_links(publication_of(robot, "/tf"), 1, 10)
    moving.send_transform(stamped("odom", "base", 5, 1.0))
    assert buffer.lookup_transform("odom", "camera", 5, timeout=10).transform.translation.x == pytest.approx(1.1)
    moving.send_transform(iter([stamped("odom", "base", 6, 2.0), stamped("map", "odom", 6, 1.0)]))
    assert buffer.lookup_transform("map", "camera", 6, timeout=10).transform.translation.x == pytest.approx(3.1)
    assert "broadcaster: '/robot'" in buffer.all_frames_as_yaml()
    TransformListener(listening, Buffer()).close()
    if callbacks == "spin":
        return  # services wait for spin()
    frames = robot.service("/viewer/tf2_frames", "tf2_msgs/FrameGraph")()
    assert "lidar: \n  parent: 'base'\n" in frames.frame_yaml


def test_a_message_of_more_than_128_kib(make_node: Make, transport: str, capfd: pytest.CaptureFixture[str]) -> None:
    robot = make_node("robot")
    moving = TransformBroadcaster(robot)
    buffer = Buffer()
    TransformListener(make_node("viewer"), buffer)
    assert wait_for_links(publication_of(robot, "/tf"), 1, 10)
    moving.send_transform([stamped("base", f"{n}" + "x" * 1000, 5) for n in range(150)])
    moving.send_transform(stamped("base", "last", 5, 1.0))
    assert buffer.lookup_transform("base", "last", 5, timeout=10).transform.translation.x == 1.0
    assert buffer.can_transform("base", "149" + "x" * 1000, 5)
    assert "internal error" not in capfd.readouterr().err


def test_a_message_that_is_used_again_is_sent_as_it_was(make_node: Make) -> None:
    static = StaticTransformBroadcaster(make_node("robot"))
    message = stamped("base", "lidar", 1, 0.5)
    static.send_transform(message)
    message.child_frame_id = "camera"
    static.send_transform(message)
    buffer = Buffer()
    TransformListener(make_node("viewer"), buffer)
    for frame in ("lidar", "camera"):
        assert buffer.lookup_transform("base", frame, timeout=10).transform.translation.x == 0.5


def test_a_late_listener_gets_all_static_transforms(make_node: Make) -> None:
    for number in range(3):
        broadcaster = StaticTransformBroadcaster(make_node(f"static{number}"))
        for child in ("a", "b"):
            broadcaster.send_transform(stamped("world", f"{child}{number}", 0, number))
    buffer = Buffer()
    with TransformListener(make_node("late"), buffer):
        for number in range(3):
            for child in ("a", "b"):
                found = buffer.lookup_transform("world", f"{child}{number}", timeout=10)
                assert found.transform.translation.x == number


def test_the_end_of_the_node_ends_waits(make_node: Make) -> None:
    node = make_node("short")
    buffer = Buffer()
    TransformListener(node, buffer)
    node.timer(0.01, lambda _: node.shutdown(), oneshot=True)
    with pytest.raises(NodeShutdownError):
        buffer.lookup_transform("map", "nope", timeout=1e6)


def test_simulated_time(make_node: Make, master: Master, capfd: pytest.CaptureFixture[str]) -> None:
    """Timeouts count in it, and when it jumps back the buffer is cleared, but for static transforms."""
    maker = make_node("simulator")
    maker.params["/use_sim_time"] = True
    clock = maker.advertise("/clock", "rosgraph_msgs/Clock", queue_size=10)
    moving, static = TransformBroadcaster(maker), StaticTransformBroadcaster(maker)
    static.send_transform(stamped("base", "lidar", 1))
    node = make_node("viewer")
    buffer = Buffer()
    listener = TransformListener(node, buffer)
    tick: Any = load_message("rosgraph_msgs/Clock")
    assert clock.wait_for_subscribers(timeout=10) and wait_for_links(publication_of(maker, "/tf"), 1, 10)
    clock.publish(tick(Time(50)))
    moving.send_transform(stamped("odom", "base", 50, 1.0))

    seconds = iter(range(51, 10_000_000, 100))
    timer = maker.timer(0.01, lambda _: clock.publish(tick(Time(next(seconds)))))
    assert buffer.can_transform("odom", "base", timeout=1e6)
    assert not buffer.can_transform("odom", "nope", timeout=500)
    timer.shutdown()
    timer.join(5)
    warned, warn = threading.Event(), node.log.warn
    node.log.warn = lambda *words: (warn(*words), warned.set())  # type: ignore[method-assign, assignment]
    clock.publish(tick(Time(10)))
    assert warned.wait(10)  # or what comes next, on another topic, could be cleared with the rest
    assert buffer.can_transform("base", "lidar")
    moving.send_transform(stamped("odom", "arm", 10, 2.0))
    assert buffer.can_transform("odom", "arm", timeout=1e6)
    assert not buffer.can_transform("odom", "base")
    moving.send_transform(stamped("odom", "leg", 10, 2.0))  # time has not gone on
    assert buffer.can_transform("odom", "leg", timeout=1e6) and buffer.can_transform("odom", "arm")
    assert capfd.readouterr().err.count("Detected jump back in time of") == 1

    listener.close()  # the buffer keeps what it has, and time goes on for those who wait
    clock.publish(tick(Time(5)))
    timer = maker.timer(0.01, lambda _: clock.publish(tick(Time(next(seconds)))))
    assert not buffer.can_transform("odom", "nope", timeout=5)
    assert buffer.can_transform("odom", "arm")
