"""teleop_twist_keyboard in a terminal."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from queue import Queue
from typing import Any

import pytest

import pyros1
from pyros1.finding.packages import OWN_PACKAGES
from pyros1.msgs.geometry_msgs.msg import Twist, TwistStamped
from pyros1.node import Node
from pyros1.robot_nodes.teleop_twist_keyboard.node import HELP_TEXT, Teleop

PATIENCE = 20.0
PROGRAM = Path(OWN_PACKAGES) / "teleop_twist_keyboard" / "scripts" / "teleop_twist_keyboard.py"


def listen(node: Node, kind: Any = Twist) -> Queue[Any]:
    twists: Queue[Any] = Queue()
    node.subscribe("cmd_vel", kind, twists.put)
    return twists


@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, None], ids=str)
def test_the_program_stops_the_robot_at_its_end(
    end: int | None, environ: dict[str, str], make_node: Callable[..., Node]
) -> None:
    """Feature: teleop_twist_keyboard, which stops the robot however it ends"""
    twists = listen(make_node("base"))
    ours, theirs = pty.openpty()
    child = subprocess.Popen(
        [sys.executable, PROGRAM, "_speed:=2", "_repeat_rate:=50"],
        env={**os.environ, **environ, "PYTHONPATH": str(Path(pyros1.__file__).parents[1])},
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        start_new_session=True,
    )
    os.close(theirs)
    try:
        assert twists.get(timeout=PATIENCE).linear.x == 0.0
        os.write(ours, b"i")
        while twists.get(timeout=PATIENCE).linear.x != 2.0:
            pass
        assert twists.get(timeout=PATIENCE).linear.x == 2.0  # repeated
        if end is None:
            os.close(ours)  # the terminal is closed
        else:
            child.send_signal(end)
        assert child.wait(PATIENCE) == 0
        last = twists.get(timeout=PATIENCE)
        while last.linear.x:
            last = twists.get(timeout=PATIENCE)
        assert twists.empty()
    finally:
        child.kill()
        child.wait()
        if end is not None:
            os.close(ours)


@pytest.mark.slow
def test_the_program_can_be_ended_while_it_waits_for_a_robot(environ: dict[str, str]) -> None:
    ours, theirs = pty.openpty()
    child = subprocess.Popen(
        [sys.executable, PROGRAM],
        env={**os.environ, **environ, "PYTHONPATH": str(Path(pyros1.__file__).parents[1])},
        stdin=theirs,
        stdout=subprocess.PIPE,
        start_new_session=True,
    )
    os.close(theirs)
    try:
        assert child.stdout is not None
        assert child.stdout.readline() == b"Waiting for subscriber to connect to /cmd_vel\n"
        child.send_signal(signal.SIGINT)
        shown, _ = child.communicate(timeout=PATIENCE)
        assert b"Drive with the keyboard" not in shown and child.returncode == 0
    finally:
        child.kill()
        child.wait()
        os.close(ours)


def test_no_key_for_some_time_stops_the_robot(make_node: Callable[..., Node], monkeypatch: pytest.MonkeyPatch) -> None:
    now = 1000.0
    monkeypatch.setattr("pyros1.robot_nodes.teleop_twist_keyboard.node.monotonic", lambda: now)
    twists = listen(make_node("base"))
    teleop = Teleop(make_node("keyboard", argv=["_key_timeout:=0.125"]))
    assert teleop.wait_for_subscribers(PATIENCE)
    now += 1.0
    assert teleop.check_timeout() > 0.125 and twists.empty()  # it does not move
    teleop.press("i")
    assert twists.get(timeout=PATIENCE).linear.x == 0.5
    now += 0.0625
    assert teleop.check_timeout() == 0.0625 and twists.empty()
    now += 0.0625
    assert teleop.check_timeout() > 0.125
    assert twists.get(timeout=PATIENCE).linear.x == 0.0


def test_stamped_twists(make_node: Callable[..., Node]) -> None:
    twists = listen(make_node("base"), TwistStamped)
    node = make_node("keyboard", argv=["_stamped:=true", "_frame_id:=base_link", "_turn:=0.25"])
    teleop = Teleop(node)
    assert teleop.wait_for_subscribers(PATIENCE)
    teleop.press("j")
    message = twists.get(timeout=PATIENCE)
    assert (message.header.frame_id, message.twist.angular.z) == ("base_link", 0.25)
    assert abs((node.now() - message.header.stamp).to_sec()) < PATIENCE
    teleop.stop()
    teleop.press("j")
    assert twists.get(timeout=PATIENCE).twist.angular.z == 0.0
    node.shutdown()
    assert twists.empty()


def test_the_keys_are_shown_again(make_node: Callable[..., Node]) -> None:
    teleop = Teleop(make_node("keyboard"))
    shown = [HELP_TEXT in teleop.press("q") for _ in range(30)]
    assert [number for number, was_shown in enumerate(shown, 1) if was_shown] == [15, 30]
