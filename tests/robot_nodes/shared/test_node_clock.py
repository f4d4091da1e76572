"""Robots are stopped even if simulated time never begins, or stops: /use_sim_time is set, but there is no /clock."""

from __future__ import annotations

import random
from collections.abc import Callable
from queue import Empty, Queue
from typing import Any

import pytest

from pyros1.ground.timing import Time
from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.rosgraph_msgs.msg import Clock
from pyros1.msgs.sensor_msgs.msg import Joy
from pyros1.msgs.visualization_msgs.msg import InteractiveMarkerFeedback
from pyros1.robot_nodes.interactive_marker_twist_server.node import MarkerServer
from pyros1.robot_nodes.shared.node_clock import PATIENCE, NodeClock
from pyros1.robot_nodes.teleop_twist_joy.node import TeleopNode
from pyros1.robot_nodes.twist_mux.node import TwistMux
from pyros1.robot_nodes.yocs_cmd_vel_mux.node import CmdVelMux
from pyros1.robot_nodes.yocs_velocity_smoother.node import VelocitySmoother

CLOCK = "pyros1.robot_nodes.shared.node_clock"
SOURCES = [{"name": "pad", "topic": "in", "timeout": 0.2, "priority": 1}]
CONFIG = "subscribers: [{name: pad, topic: in, timeout: 0.2, priority: 1}]"
COMMAND = Twist()
COMMAND.linear.x = 1.0
DRAGGED = InteractiveMarkerFeedback(marker_name="robot_twist_marker")
DRAGGED.header.frame_id, DRAGGED.pose.position.x, DRAGGED.pose.orientation.w = "base_link", 1.0, 1.0


@pytest.mark.parametrize(
    ("start", "topic", "output", "command"),
    [
        (TwistMux, "/in", "/cmd_vel_out", COMMAND),
        (CmdVelMux, "/driver/in", "/driver/output", COMMAND),
        (MarkerServer, "/twist_marker_server/feedback", "/driver/cmd_vel", DRAGGED),
        (TeleopNode, "/joy", "/cmd_vel", Joy(axes=[0.0, 1.0], buttons=[1])),
    ],
)
def test_a_robot_is_stopped_before_simulated_time_begins(
    make_node: Callable[..., Any], start: Callable[[Any], Any], topic: str, output: str, command: Any
) -> None:
    user, pad = make_node("user"), make_node("pad")
    user.params["/use_sim_time"] = True
    user.params["/driver"] = {"topics": SOURCES, "yaml_cfg_data": CONFIG}
    came: Queue[float] = Queue()
    subscriber = user.subscribe(output, Twist, lambda twist: came.put(twist.linear.x))
    node = make_node("driver")
    running = start(node)
    publisher = pad.advertise(topic, type(command))
    assert publisher.wait_for_subscribers(timeout=20) and subscriber.wait_for_publishers(timeout=20)
    publisher.publish(command)
    assert came.get(timeout=20) > 0.0
    pad.shutdown()
    assert came.get(timeout=20) == 0.0
    del running


LIMITS = {"speed_lim_v": 1.0, "speed_lim_w": 1.0, "accel_lim_v": 10.0, "accel_lim_w": 10.0, "frequency": 100.0}


@pytest.mark.parametrize(
    ("start", "topic", "output", "command"),
    [
        (TwistMux, "/in", "/cmd_vel_out", COMMAND),
        (CmdVelMux, "/driver/in", "/driver/output", COMMAND),
        (MarkerServer, "/twist_marker_server/feedback", "/driver/cmd_vel", DRAGGED),
        (VelocitySmoother, "/driver/raw_cmd_vel", "/driver/smooth_cmd_vel", COMMAND),
    ],
)
def test_a_robot_is_stopped_when_simulated_time_stops(
    make_node: Callable[..., Any],
    monkeypatch: pytest.MonkeyPatch,
    start: Callable[[Any], Any],
    topic: str,
    output: str,
    command: Any,
) -> None:
    monkeypatch.setattr(f"{CLOCK}.PATIENCE", 0.3)
    monkeypatch.setattr("pyros1.robot_nodes.interactive_marker_twist_server.node.MAX_SILENCE", 0.1)
    user, pad = make_node("user"), make_node("pad")
    user.params["/use_sim_time"] = True
    user.params["/driver"] = {"topics": SOURCES, "yaml_cfg_data": CONFIG, **LIMITS}
    came: Queue[float] = Queue()
    user.subscribe(output, Twist, lambda twist: came.put(twist.linear.x))
    clock = pad.advertise("/clock", Clock, latch=True)
    clock.publish(Clock(clock=Time(100, 0)))
    node = make_node("driver")
    running = start(node)
    publisher = pad.advertise(topic, type(command))
    assert publisher.wait_for_subscribers(timeout=20)
    for step in range(1, 1000):
        clock.publish(Clock(clock=Time.from_sec(100 + step * 0.02)))
        publisher.publish(command)
        try:
            if came.get(timeout=0.02) > 0.0:
                break
        except Empty:
            pass
    while came.get(timeout=20) > 0.0:  # now there are no more ticks
        pass
    del running


class FakeNode:
    """A node in simulated time."""

    def __init__(self) -> None:
        self.simulated_time = True
        self.time = 0.0
        self.warnings: list[str] = []
        self.log = self

    def now(self) -> Time:
        return Time.from_sec(self.time)

    def warn(self, text: str, *args: object) -> None:
        self.warnings.append(text % args)


def test_real_time_counts_only_while_simulated_time_stands_still(monkeypatch: pytest.MonkeyPatch) -> None:
    for seed in range(30):
        chance = random.Random(seed)
        node, real = FakeNode(), 50.0
        monkeypatch.setattr(f"{CLOCK}.monotonic", lambda: real)  # noqa: B023
        clock: Any = NodeClock(node)  # type: ignore[arg-type]
        last, expected, silence = clock.seconds(), 0.0, 0.0
        begin, num_stops = last, 0
        for _ in range(300):
            elapsed = chance.uniform(0.01, 0.5)
            real += elapsed
            if chance.random() < (0.02 if silence else 0.7):
                step = chance.choice([0.001, 0.1, 3.0])
                expected += (
                    step
                    + max(0.0, silence + elapsed - (PATIENCE if node.time else 0.0))
                    - max(0.0, silence - (PATIENCE if node.time else 0.0))
                )
                node.time, silence = round(node.time + step, 6), 0.0
            else:
                patience = PATIENCE if node.time else 0.0
                expected += max(0.0, silence + elapsed - patience) - max(0.0, silence - patience)
                num_stops += bool(node.time) and silence <= patience < silence + elapsed
                silence += elapsed
            now = clock.seconds()
            assert now >= last and now - begin == pytest.approx(expected, abs=1e-6)
            assert clock.stands_still() is (silence > (PATIENCE if node.time else 0.0))
            last = now
        assert len(node.warnings) == num_stops
        node.time /= 2
        assert clock.seconds() < last or not node.time, "a simulation that begins again"


def test_without_simulated_time(monkeypatch: pytest.MonkeyPatch) -> None:
    node = FakeNode()
    node.simulated_time = False
    monkeypatch.setattr(f"{CLOCK}.monotonic", lambda: 7.0)
    clock = NodeClock(node)  # type: ignore[arg-type]
    assert clock.seconds() == 7.0 and not clock.stands_still()
