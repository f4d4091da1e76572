"""cmd_vel_mux as a node."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import closing
from math import nan
from pathlib import Path
from queue import Queue
from typing import Any

import pytest

from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.std_msgs.msg import String
from pyros1.node.subscribing.subscriber import Subscriber
from pyros1.reconfigure import Client
from pyros1.robot_nodes.yocs_cmd_vel_mux.node import CmdVelMux

Make = Callable[..., Any]
MUX = """subscribers:
  - {name: Safety, topic: input/safety, timeout: 0.2, priority: 10}
  - {name: Teleoperation, topic: input/teleop, timeout: 60, priority: 7}
"""


def twist(speed: float) -> Any:
    message = Twist()
    message.linear.x = speed
    return message


def test_sources_take_over_and_the_robot_is_stopped(
    make_node: Make, tmp_path: Path, next_of: Callable[..., Any], capfd: pytest.CaptureFixture[str]
) -> None:
    """Feature: cmd_vel_mux selects by priority, and stops the robot when its source is silent"""
    (tmp_path / "mux.yaml").write_text(MUX)
    user = make_node("user")
    names: Queue[Any] = Queue()
    came: Queue[Any] = Queue()
    user.subscribe("mux/active", String, lambda message: names.put(message.data))
    subscriber = user.subscribe("/base", Twist, came.put)
    CmdVelMux(make_node("mux", argv=[f"_yaml_cfg_file:={tmp_path}/mux.yaml", "mux/output:=base"]))
    safety, teleop = (user.advertise(f"mux/input/{name}", Twist) for name in ("safety", "teleop"))
    for publisher in (safety, teleop):
        assert publisher.wait_for_subscribers(timeout=20)
    assert subscriber.wait_for_publishers(timeout=20)
    assert names.get(timeout=20) == "idle"
    teleop.publish(twist(nan))
    teleop.publish(twist(1.0))
    assert (names.get(timeout=20), came.get(timeout=20).linear.x) == ("Teleoperation", 1.0)
    safety.publish(twist(2.0))
    assert (names.get(timeout=20), came.get(timeout=20).linear.x) == ("Safety", 2.0)
    teleop.publish(twist(1.0))
    assert (names.get(timeout=20), came.get(timeout=20).linear.x) == ("idle", 0.0)
    teleop.publish(twist(3.0))
    assert names.get(timeout=20) == "Teleoperation"
    next_of(came, lambda twist: twist.linear.x == 3.0)  # after 1.0, if that came when the other source had timed out
    with closing(Client(user, "mux")) as client:
        client.update({"yaml_cfg_data": "subscribers: 5"})
        assert "yaml_cfg_data: subscribers must be a list, not 5" in capfd.readouterr().err
        client.update({"yaml_cfg_data": MUX.replace("teleop", "other") + "publisher: out"})
    assert (names.get(timeout=20), came.get(timeout=20).linear.x) == ("idle", 0.0)
    end = time.monotonic() + 20
    while teleop.num_connections:
        assert time.monotonic() < end, "it still listens to what is not in the new configuration"
        time.sleep(0.001)
    user.subscribe("mux/out", Twist, came.put)
    other = user.advertise("mux/input/other", Twist, latch=True)
    other.publish(twist(4.0))
    assert names.get(timeout=20) == "Teleoperation"


def test_without_a_configuration(make_node: Make, capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    CmdVelMux(make_node("mux"))
    assert "the parameter yaml_cfg_file is not set, so nothing can drive the robot" in capfd.readouterr().err
    CmdVelMux(make_node("other", argv=[f"_yaml_cfg_file:={tmp_path}/none.yaml"]))
    assert "cannot read the file that yaml_cfg_file names: [Errno 2] No such file" in capfd.readouterr().err


def test_the_robot_is_stopped_even_if_the_master_is_slow_when_the_configuration_is_replaced(
    make_node: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    user, node = make_node("user"), make_node("mux", argv=["mux/output:=base"])
    node.params["~yaml_cfg_data"] = MUX
    came: Queue[Any] = Queue()
    subscriber = user.subscribe("/base", Twist, came.put)
    master_responds = threading.Event()
    unregister = Subscriber.unregister

    def unregister_slowly(subscriber: Any) -> None:
        master_responds.wait(20)
        unregister(subscriber)

    CmdVelMux(node)
    teleop = user.advertise("mux/input/teleop", Twist)
    assert teleop.wait_for_subscribers(timeout=20) and subscriber.wait_for_publishers(timeout=20)
    teleop.publish(twist(1.0))
    assert came.get(timeout=20).linear.x == 1.0
    monkeypatch.setattr(Subscriber, "unregister", unregister_slowly)
    with closing(Client(user, "mux")) as client:
        caller = threading.Thread(target=client.update, args=({"yaml_cfg_data": f"{MUX}publisher: out"},))
        caller.start()
        try:
            assert came.get(timeout=10).linear.x == 0.0
        finally:
            master_responds.set()
            caller.join()


def test_a_configuration_with_a_wrong_name_is_not_used(make_node: Make, capfd: pytest.CaptureFixture[str]) -> None:
    user, node = make_node("user"), make_node("mux", argv=["mux/output:=base"])
    node.params["~yaml_cfg_data"] = MUX
    came: Queue[Any] = Queue()
    subscriber = user.subscribe("/base", Twist, came.put)
    CmdVelMux(node)
    with closing(Client(user, "mux")) as client:
        client.update({"yaml_cfg_data": MUX.replace("input/teleop", "in put")})
        client.update({"yaml_cfg_data": f"{MUX}publisher: out put"})
    assert capfd.readouterr().err.count(" put") == 2
    teleop = user.advertise("mux/input/teleop", Twist)
    assert teleop.wait_for_subscribers(timeout=20) and subscriber.wait_for_publishers(timeout=20)
    teleop.publish(twist(1.0))
    assert came.get(timeout=20).linear.x == 1.0


def test_configurations_leave_nothing_behind(make_node: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    user, node = make_node("user"), make_node("mux")
    hooks: list[Any] = []
    register = node.on_shutdown

    def note(*args: Any) -> None:
        hooks.append(args)
        register(*args)

    monkeypatch.setattr(node, "on_shutdown", note)
    node.params["~yaml_cfg_data"] = MUX
    came: Queue[Any] = Queue()
    CmdVelMux(node)
    count = len(hooks)
    with closing(Client(user, "mux")) as client:
        for number in range(3):
            client.update({"yaml_cfg_data": f"{MUX}publisher: out{number}"})
    assert len(hooks) == count
    user.subscribe("/mux/out2", Twist, came.put)
    teleop = user.advertise("mux/input/teleop", Twist)
    assert teleop.wait_for_subscribers(timeout=20)
    while came.empty():  # until the subscriber is connected
        teleop.publish(twist(1.0))
    node.shutdown()
    while came.get(timeout=20).linear.x:  # the robot is stopped
        pass
