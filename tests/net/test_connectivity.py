"""net.connectivity: what to do about a node that cannot be reached.

Feature: errors name an unreachable address, and say what to set where
"""

from __future__ import annotations

import re
import socket

import pytest

from pyros1.ground.errors import DeadlineError, UnknownHostError, UnreachableError
from pyros1.net.connectivity import connectivity_hint, is_loopback


def caused(cause: OSError) -> UnreachableError:
    error = UnreachableError("cannot connect")
    error.__cause__ = cause
    return error


@pytest.mark.parametrize(
    ("host", "error", "words"),
    [
        ("robot", UnknownHostError("robot", socket.gaierror(-2, "unknown")), "ROS_IP.*'ADDRESS robot' to /etc/hosts"),
        ("localhost", caused(ConnectionRefusedError()), "on its machine unset ROS_HOSTNAME, export ROS_IP"),
        ("127.0.1.1", None, "means this machine here"),
        ("robot", caused(ConnectionResetError()), r"PYROS1_ALLOW \(or --allow\) on \[robot\] include this machine"),
        ("robot", caused(ConnectionRefusedError()), "node cleanup.*ROS_IP.*firewall"),
        ("robot", caused(OSError(113, "No route to host")), r"Is \[robot\] switched on.*ROS_IP.*firewall"),
        ("robot", DeadlineError("late"), "ROS_IP.*PYROS1_PORTS"),
    ],
)
def test_each_kind_has_a_cure(host: str, error: BaseException | None, words: str) -> None:
    assert re.search(words, connectivity_hint(host, error))


def test_where_all_use_a_loopback_address_other_machines_are_not_suspected() -> None:
    refused = caused(ConnectionRefusedError())
    assert connectivity_hint("localhost", refused, "127.0.0.1") == "Has it exited? Then run: pyros1 node cleanup"
    for own in ("", "laptop"):
        text = connectivity_hint("localhost", refused, own)
        assert text.startswith("Has it exited? Then run: pyros1 node cleanup") and "unset ROS_HOSTNAME" in text


@pytest.mark.parametrize("own", ["", "laptop", "localhost"])
def test_a_process_of_this_machine_that_does_not_answer_hangs(own: str) -> None:
    assert "kill -CONT" in connectivity_hint("localhost", DeadlineError("late"), own)


def test_loopback() -> None:
    assert all(map(is_loopback, ("localhost", "127.0.0.1", "127.9.9.9", "::1")))
    assert not any(map(is_loopback, ("", "robot", "10.0.0.1", "fd00::1")))
