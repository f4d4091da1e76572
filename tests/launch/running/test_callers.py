"""Who may control a launch."""

from __future__ import annotations

import os
import socket
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from pyros1.launch.running.callers import address_refusal_reason, refusal_reason

HEAD = "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n"
HERE = ("127.0.0.1", 0x1F90)
THERE = ("127.0.0.1", 0xC000)

pytestmark = pytest.mark.skipif(sys.byteorder != "little", reason="tables as a machine of the other order writes them")


@pytest.fixture
def proc(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes a table of connections, with one between the two ends, of a user."""

    def write(user: int, name: str = "tcp", local: str = "0100007F", remote: str = "0100007F") -> Path:
        (tmp_path / "net").mkdir()
        rows = [
            f"   0: {remote}:1F90 {local}:C000 01 00000000:00000000 00:00000000 00000000  4242        0 1\n",  # our end
            f"   1: {local}:C000 {remote}:1F90 01 00000000:00000000 00:00000000 00000000  {user}        0 2\n",
        ]
        (tmp_path / "net" / name).write_text(HEAD + "".join(rows))
        return tmp_path

    return write


def test_the_same_user_and_root_may(proc: Callable[..., Path]) -> None:
    assert address_refusal_reason(THERE, HERE, proc(os.getuid())) == ""


def test_root_may(proc: Callable[..., Path]) -> None:
    assert address_refusal_reason(THERE, HERE, proc(0)) == ""


def test_others_may_not(proc: Callable[..., Path]) -> None:
    assert "by its own user" in address_refusal_reason(THERE, HERE, proc(4711))


def test_who_is_not_in_the_table_may_not(proc: Callable[..., Path]) -> None:
    assert address_refusal_reason(("127.0.0.1", 5), HERE, proc(os.getuid()))


def test_ends_of_ipv6(proc: Callable[..., Path]) -> None:
    one = "0" * 24 + "01000000"
    assert address_refusal_reason(("::1", 0xC000), ("::1", 0x1F90), proc(os.getuid(), "tcp6", one, one)) == ""


def test_ends_of_ipv4_within_ipv6(proc: Callable[..., Path]) -> None:
    wrapped = "0000000000000000FFFF00000100007F"
    assert address_refusal_reason(THERE, HERE, proc(os.getuid(), "tcp6", wrapped, wrapped)) == ""


def test_other_machines_may_not(proc: Callable[..., Path]) -> None:
    assert "from its own machine" in address_refusal_reason(("192.0.2.7", 0xC000), HERE, proc(os.getuid()))


def test_without_a_table_the_machine_must_do(tmp_path: Path) -> None:
    assert address_refusal_reason(THERE, HERE, tmp_path) == ""


@pytest.mark.parametrize("family", [socket.AF_INET, socket.AF_INET6])
def test_a_real_connection(family: socket.AddressFamily) -> None:
    host = "127.0.0.1" if family is socket.AF_INET else "::1"
    try:
        listener = socket.create_server((host, 0), family=family)
    except OSError:
        assert family is socket.AF_INET6, "some machines have none"
        return
    with listener, socket.create_connection(listener.getsockname()[:2], timeout=10):
        connection, _ = listener.accept()
        with connection:
            assert refusal_reason(connection) == ""
