"""net.ports: a free port of a range, and what is said if there is none.

Feature: nodes behind a firewall that allows only some ports
"""

from __future__ import annotations

import errno
import socket
from contextlib import ExitStack
from pathlib import Path

import pytest

from pyros1.ground.errors import SettingError
from pyros1.net.ports import BACKLOG, PortRange, datagram_socket, listening_socket, parse_ports


@pytest.mark.parametrize(
    ("text", "ports"),
    [("40000-40099", (40000, 40099)), (" 1 - 65535 ", (1, 65535)), ("40000", (40000, 40000)), ("7-7", (7, 7))],
)
def test_ranges(text: str, ports: tuple[int, int]) -> None:
    assert parse_ports(text) == ports


@pytest.mark.parametrize("text", ["", "a-b", "0-5", "5-4", "1-65536", "1-2-3", "-5", "40000,40001", "\u0661-\u0665"])
def test_wrong_ranges(text: str) -> None:
    with pytest.raises(SettingError, match=r"PYROS1_PORTS .* such as 40000-40099"):
        parse_ports(text)


def test_each_port_is_tried_once_from_a_random_one_on() -> None:
    ports = PortRange(50, 59)
    orders = {tuple(ports.iterate_from_random_start()) for _ in range(100)}
    assert all(sorted(order) == [*range(50, 60)] for order in orders)
    assert len(orders) > 3


def test_all_ports_of_a_range_can_be_had_and_no_more(free_port: int) -> None:
    ports = PortRange(free_port, free_port + 2)
    with ExitStack() as stack:
        with socket.create_server(("127.0.0.1", free_port + 1)):  # another program's
            had = [stack.enter_context(listening_socket("127.0.0.1", 0, ports)) for _ in range(2)]
            assert {sock.getsockname()[1] for sock in had} == {free_port, free_port + 2}
            with pytest.raises(OSError, match=f"PYROS1_PORTS={free_port}-{free_port + 2} are in use") as caught:
                listening_socket("127.0.0.1", 0, ports)
            assert caught.value.errno == errno.EADDRINUSE
        datagrams = [stack.enter_context(datagram_socket("127.0.0.1", ports)) for _ in range(3)]
        assert len({sock.getsockname()[1] for sock in datagrams}) == 3
        with pytest.raises(OSError, match="are in use"):
            datagram_socket("127.0.0.1", ports)


def test_a_wanted_port_goes_before_the_range(free_port: int) -> None:
    with listening_socket("127.0.0.1", free_port, PortRange(50, 59)) as sock:
        assert sock.getsockname()[1] == free_port


def test_an_address_of_another_machine() -> None:
    with pytest.raises(OSError, match=r"192\.0\.2\.1 is not an address of this machine"):
        listening_socket("192.0.2.1", 0, PortRange(40000, 40001))


def test_all_addresses_of_ipv6_take_ipv4_too() -> None:
    with listening_socket("::") as sock:
        socket.create_connection(("127.0.0.1", sock.getsockname()[1]), timeout=20).close()
        guest, address = sock.accept()
        guest.close()
        assert address[0] == "::ffff:127.0.0.1"


def test_many_connections_may_come_at_once() -> None:
    """What finds no place is asked for again by the system, after a second: a topic may have a thousand subscribers."""
    with listening_socket("127.0.0.1") as listener, ExitStack() as stack:
        most = min(BACKLOG, int(Path("/proc/sys/net/core/somaxconn").read_text(encoding="ascii")))
        for _ in range(min(most, 400)):
            sock = stack.enter_context(socket.socket())
            sock.settimeout(0.5)
            sock.connect(listener.getsockname())
