"""net.hosts: what is advertised, where to listen, which master (N18-N26)."""

from __future__ import annotations

import socket

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import ProtocolError, SettingError
from pyros1.net import hosts

ANY = "0.0.0.0"


@pytest.mark.parametrize(
    ("environ", "special", "advertised", "bind"),
    [
        ({"ROS_HOSTNAME": "robot"}, {}, "robot", ANY),
        ({"ROS_HOSTNAME": "robot", "ROS_IP": "10.0.0.1"}, {}, "robot", ANY),
        ({"ROS_IP": "10.0.0.1"}, {}, "10.0.0.1", ANY),
        ({"ROS_HOSTNAME": "robot"}, {"__ip": "10.0.0.2"}, "10.0.0.2", ANY),
        ({"ROS_HOSTNAME": "robot"}, {"__ip": "10.0.0.2", "__hostname": "me"}, "me", ANY),
        ({"ROS_HOSTNAME": "localhost"}, {}, "localhost", "127.0.0.1"),
        ({"ROS_HOSTNAME": "127.0.0.1"}, {}, "127.0.0.1", "127.0.0.1"),
        ({"ROS_IP": "127.0.0.1"}, {}, "127.0.0.1", "127.0.0.1"),
        ({"ROS_IP": "127.0.0.5"}, {}, "127.0.0.5", "127.0.0.5"),
        ({"ROS_IP": "::1", "ROS_IPV6": "on"}, {}, "::1", "::1"),
        ({"ROS_HOSTNAME": "robot", "ROS_IPV6": "on"}, {}, "robot", "::"),
        ({"ROS_HOSTNAME": "localhost", "ROS_IPV6": "on"}, {}, "localhost", "::1"),
    ],
)
def test_n18_n19_n23_overrides(environ: dict[str, str], special: dict[str, str], advertised: str, bind: str) -> None:
    address = hosts.addresses_from_environment(environ, special)
    assert (address.advertised, address.bind) == (advertised, bind)
    assert address.family == (socket.AF_INET6 if ":" in bind else socket.AF_INET)
    assert address.warnings == []


def test_n18_without_overrides(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(socket, "gethostname", lambda: "robot")
    assert hosts.addresses_from_environment({}, {}).advertised == "robot"
    monkeypatch.setattr(socket, "gethostname", lambda: "localhost")
    monkeypatch.setattr(hosts, "interface_addresses", lambda ipv6=False: ["127.0.0.1", "10.1.2.3"])
    assert hosts.addresses_from_environment({}, {}).advertised == "10.1.2.3"
    monkeypatch.setattr(hosts, "interface_addresses", lambda ipv6=False: ["127.0.0.1"])
    address = hosts.addresses_from_environment({}, {})
    assert (address.advertised, address.bind) == ("127.0.0.1", ANY)


def test_interface_addresses_hold_the_loopback() -> None:
    assert "127.0.0.1" in hosts.interface_addresses()


@pytest.mark.parametrize(
    ("environ", "words"),
    [
        ({"ROS_HOSTNAME": ""}, "ROS_HOSTNAME (an empty string)"),
        ({"ROS_HOSTNAME": "http://robot"}, "protocol"),
        ({"ROS_HOSTNAME": "robot:11311"}, "port"),
        ({"ROS_IP": ""}, "ROS_IP (an empty string)"),
        ({"ROS_IP": "http://1.2.3.4"}, "protocol"),
        ({"ROS_IP": "1.2.3.4:5"}, "not an IP"),
        ({"ROS_IP": "robot"}, "not an IP"),
    ],
)
def test_n22_warnings(environ: dict[str, str], words: str) -> None:
    (warning,) = hosts.addresses_from_environment(environ, {}).warnings
    assert words in warning


@pytest.mark.parametrize(
    ("environ", "special", "advertised", "bind"),
    [
        ({"PYROS1_BIND": "127.0.0.2"}, {}, "127.0.0.2", "127.0.0.2"),  # reached nowhere else
        ({"PYROS1_BIND": "127.0.0.2", "ROS_HOSTNAME": "robot"}, {}, "robot", "127.0.0.2"),
        ({"PYROS1_BIND": "0.0.0.0", "ROS_HOSTNAME": "localhost"}, {}, "localhost", ANY),
        ({"PYROS1_BIND": "127.0.0.2", "ROS_HOSTNAME": "robot"}, {"__bind": "localhost"}, "robot", "127.0.0.1"),
        ({"PYROS1_BIND": "::1", "ROS_IP": "::1"}, {}, "::1", "::1"),
        ({"PYROS1_BIND": "", "ROS_IP": "10.0.0.1"}, {}, "10.0.0.1", ANY),
    ],
)
def test_where_to_listen(environ: dict[str, str], special: dict[str, str], advertised: str, bind: str) -> None:
    address = hosts.addresses_from_environment(environ, special)
    assert (address.advertised, address.bind) == (advertised, bind)
    assert address.family == (socket.AF_INET6 if ":" in bind else socket.AF_INET)


def test_who_may_connect_and_which_ports() -> None:
    environ = {"PYROS1_ALLOW": "10.0.0.0/8", "PYROS1_PORTS": "40000-40099"}
    address = hosts.addresses_from_environment(environ, {})
    assert (str(address.allowed), str(address.ports)) == ("10.0.0.0/8", "40000-40099")
    address = hosts.addresses_from_environment(environ, {"__allow": "10.0.0.1", "__ports": "50000"})
    assert (str(address.allowed), str(address.ports)) == ("10.0.0.1", "50000-50000")
    address = hosts.addresses_from_environment({"PYROS1_ALLOW": "", "PYROS1_PORTS": ""}, {})
    assert address.allowed is None and address.ports is None


@pytest.mark.parametrize("text", ["192.0.2.1", "robot", "127.0.0.1/8", "eth0"])
def test_an_address_to_listen_on_that_is_not_here(text: str) -> None:
    with pytest.raises(SettingError, match=r"PYROS1_BIND .* not an address of this machine: .* are .*127\.0\.0\.1"):
        hosts.addresses_from_environment({"PYROS1_BIND": text}, {})


def test_make_uri() -> None:
    assert hosts.make_uri("robot", 5) == "http://robot:5/"
    assert hosts.parse_uri(hosts.make_uri("fd00::1", 5, "rosrpc"), "rosrpc") == ("fd00::1", 5)


def test_n25_master_uri() -> None:
    assert hosts.master_uri({}, {}) == "http://localhost:11311"
    assert hosts.master_uri({"ROS_MASTER_URI": "http://a:1"}, {}) == "http://a:1"
    assert hosts.master_uri({"ROS_MASTER_URI": "http://a:1"}, {"__master": "http://b:2"}) == "http://b:2"


@pytest.mark.parametrize(
    ("uri", "scheme", "result"),
    [
        ("http://robot:11311", "http", ("robot", 11311)),
        ("http://robot:11311/", "http", ("robot", 11311)),
        ("HTTP://robot:11311/RPC2?x", "http", ("robot", 11311)),
        ("http://robot/", "http", ("robot", 80)),
        ("http://[::1]:5/", "http", ("::1", 5)),
        ("rosrpc://robot-2.local:65535", "rosrpc", ("robot-2.local", 65535)),
        ("http://user@robot:5/", "http", ("robot", 5)),
    ],
)
def test_parse_uri(uri: str, scheme: str, result: tuple[str, int]) -> None:
    assert hosts.parse_uri(uri, scheme) == result


@pytest.mark.parametrize(
    "uri",
    [
        "",
        "robot:1",
        "http://",
        "http://:5",
        "http://robot:0",
        "http://robot:65536",
        "http://ro bot:1",
        "http://a:b",
        "rosrpc://a:1",
    ],
)
def test_parse_uri_refuses(uri: str) -> None:
    with pytest.raises(ProtocolError):
        hosts.parse_uri(uri)
    with pytest.raises(ProtocolError):
        hosts.parse_uri("rosrpc://robot", "rosrpc")


@given(st.text())
def test_parse_uri_gives_a_place_or_a_protocol_error(text: str) -> None:
    for uri in (text, "http://" + text):
        try:
            host, port = hosts.parse_uri(uri)
        except ProtocolError:
            continue
        assert host
        assert 0 < port < 65536


def test_is_local(monkeypatch: pytest.MonkeyPatch) -> None:
    for host in ("localhost", "127.0.0.1", "127.1.2.3", "::1", socket.gethostname()):
        assert hosts.is_local(host)
    assert not hosts.is_local("192.0.2.1")
    assert not hosts.is_local("0.0.0.0")
    monkeypatch.setattr(hosts, "resolve_host", lambda host: ["192.0.2.1", "127.0.0.1"])
    assert hosts.is_local("me")
    monkeypatch.setattr(hosts, "resolve_host", lambda host: ["192.0.2.1"])
    assert not hosts.is_local("other")
