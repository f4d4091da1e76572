"""net.allowlist: who may connect, by address.

Feature: unwanted connections are refused before a byte is read
"""

from __future__ import annotations

import contextlib
import socket

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import SettingError
from pyros1.net.allowlist import Allowlist, Networks


@pytest.mark.parametrize(
    ("text", "inside", "outside"),
    [
        ("192.168.1.0/24", ["192.168.1.1", "192.168.1.255", "::ffff:192.168.1.7"], ["192.168.2.1", "::1", "fe80::1"]),
        ("10.0.0.7, 10.1.0.0/16", ["10.0.0.7", "10.1.255.255"], ["10.0.0.8", "10.2.0.0"]),
        ("10.0.0.7 10.0.0.8,,", ["10.0.0.7", "10.0.0.8"], ["10.0.0.9"]),
        ("fd00::/8 fe80::/10", ["fd12::5", "fe80::1%eth0"], ["fc00::1", "10.0.0.1"]),
        ("localhost", ["127.0.0.1", "127.9.9.9", "::1"], ["10.0.0.1"]),
        ("0.0.0.0/0", ["8.8.8.8"], ["fd00::1", "robot", ""]),
    ],
)
def test_networks(text: str, inside: list[str], outside: list[str]) -> None:
    networks = Networks(text)
    assert [address for address in inside if address not in networks] == []
    assert [address for address in outside if address in networks] == []


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("robot", "neither an address nor a network"),
        ("10.0.0.0/33", "neither"),
        ("10.0.0.1/24", "use 10.0.0.0/24 for the network, or 10.0.0.1"),
        (" , ", "is empty"),
        ("10.0.0.1;10.0.0.2", "neither"),
    ],
)
def test_wrong_networks(text: str, words: str) -> None:
    with pytest.raises(SettingError, match="PYROS1_ALLOW") as caught:
        Networks(text)
    assert words in str(caught.value)


@given(st.text())
def test_any_text_is_networks_or_an_error(text: str) -> None:
    with contextlib.suppress(SettingError):
        assert "8.8.8.8" not in Networks(text) or text.strip()


def test_this_machine_always_may_come() -> None:
    told: list[str] = []
    allowlist = Allowlist(Networks("10.0.0.0/24"), told.append)
    assert allowlist.admit_address("127.0.0.1", "127.0.0.1")
    assert allowlist.admit_address("::ffff:127.0.0.1", "::")
    assert allowlist.admit_address("192.168.1.5", "192.168.1.5")  # its own address, called by itself
    assert allowlist.admit_address("::ffff:192.168.1.5", "::ffff:192.168.1.5")
    assert allowlist.admit_address("10.0.0.9", "192.168.1.5")
    assert told == []


def test_a_peer_whose_address_is_not_of_ip_is_refused() -> None:
    reports: list[str] = []
    allowlist = Allowlist(Networks("0.0.0.0/0, ::/0"), reports.append)
    assert not allowlist.admit_address("robot", "192.168.1.5")
    assert not allowlist.admit_address("", "")
    assert "refused a connection from robot" in reports[0]


def test_others_are_told_of_once_and_not_all_are_remembered() -> None:
    told: list[str] = []
    allowlist = Allowlist(Networks("10.0.0.0/24"), told.append)
    for _ in range(3):
        assert not allowlist.admit_address("192.168.1.6", "192.168.1.5")
        assert not allowlist.admit_address("::ffff:192.168.1.6", "::ffff:192.168.1.5")
    (text,) = told
    assert "192.168.1.6" in text and "PYROS1_ALLOW='10.0.0.0/24, 192.168.1.6'" in text
    for number in range(3000):
        allowlist.admit_address(f"172.16.{number // 250}.{number % 250}", "192.168.1.5")
    assert len(told) == 3001
    assert not allowlist.admit_address("192.168.1.6", "192.168.1.5")
    assert len(told) == 3002  # forgotten meanwhile: the memory is bounded


def test_the_connection_of_one_who_may_not_come_is_reset() -> None:
    with (
        socket.create_server(("127.0.0.1", 0)) as listener,
        socket.create_connection(listener.getsockname(), timeout=5) as guest,
    ):
        guest.sendall(b"POST / HTTP/1.1\r\n")
        accepted, address = listener.accept()
        assert Allowlist(Networks("10.0.0.1"), print).admit(accepted, address)
        assert not Allowlist(Networks("10.0.0.1"), lambda _: None).admit(accepted, ("10.0.0.2", 5))
        assert accepted.fileno() == -1
        with pytest.raises(ConnectionResetError):
            guest.recv(1)
