"""Options of a node that programs written for rospy need: ports, wall time, names that break the rules."""

from __future__ import annotations

import gc
import os
import threading
import warnings
from typing import Any

import pytest

import pyros1
from pyros1.net.hosts import parse_uri
from pyros1.node.log.levels import INFO

from ..parts import subscription_of, tcpros_port


def test_ports(make_node: Any, free_port: int) -> None:
    assert tcpros_port(make_node("a", ports=(0, free_port))) == free_port
    b = make_node("b", ports=(free_port + 1, 0))
    assert parse_uri(b.uri)[1] == free_port + 1


def test_a_range_of_ports(make_node: Any, free_port: int, environ: Any, collect: Any, monkeypatch: Any) -> None:
    """For firewalls: all that a node listens at, also for datagrams, is in the range."""
    monkeypatch.setattr("pyros1.node.subscribing.connector.find_local_context", lambda uri: None)
    allowed, got = {*range(free_port, free_port + 6)}, collect()
    narrow = {**environ, "PYROS1_PORTS": f"{free_port}-{free_port + 5}"}
    talker = make_node("talker", environ=narrow)
    listener = make_node("listener", argv=[f"__ports:={free_port}-{free_port + 5}"])
    used = {parse_uri(node.uri)[1] for node in (talker, listener)} | {tcpros_port(node) for node in (talker, listener)}
    assert len(used) == 4 and used <= allowed
    talker.advertise("t", "std_msgs/Float64", latch=True).publish(3)
    subscriber = listener.subscribe("t", "std_msgs/Float64", got, transports=("udp",))
    assert got.wait() and subscriber.wait_for_publishers(timeout=20)
    (link,) = subscription_of(listener).links
    assert int(link.address.split("port ")[1].split()[0]) in allowed
    make_node("third", environ=narrow)
    with pytest.raises(pyros1.NodeError, match=r"/fourth cannot listen on .*: all ports of PYROS1_PORTS="):
        make_node("fourth", environ=narrow)


def test_settings_that_are_wrong(make_node: Any, environ: Any) -> None:
    for setting in ({"PYROS1_PORTS": "many"}, {"PYROS1_ALLOW": "everybody"}, {"PYROS1_BIND": "here"}):
        with pytest.raises(pyros1.SettingError):
            make_node("node", environ={**environ, **setting})


def test_names_that_break_the_rules(make_node: Any, collect: Any) -> None:
    with pytest.raises(pyros1.InvalidNameError):
        make_node("my-node")
    node = make_node("my-node", strict_names=False, argv=["ab:=c.d"])
    assert node.name == "/my-node" and node.resolve("ab") == "/c.d"
    got = collect()
    node.subscribe("2d", "std_msgs/Float64", got)
    publisher = node.advertise("2d", "std_msgs/Float64")
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(3)
    assert got.wait() and got.data == [3]


def test_wall_time_in_a_simulation(make_node: Any) -> None:
    make_node("world").params["/use_sim_time"] = True
    assert make_node("simulated").simulated_time
    assert not make_node("real", wall_time=True).simulated_time


def test_a_handler_that_refuses(make_node: Any, watch_log: Any) -> None:
    node = make_node("a")
    log = watch_log(node)

    def refuse(_: Any) -> None:
        raise pyros1.ServiceRefusal("not today")

    node.advertise_service("s", "std_srvs/Trigger", refuse)
    with pytest.raises(pyros1.ServiceError, match=r"responded with an error: not today\Z") as failure:
        node.service("s", "std_srvs/Trigger")()
    assert failure.value.answer == b"not today"
    assert not [text for text in log.texts if "error processing" in text]


def test_the_masters_whole_answer(make_node: Any) -> None:
    node = make_node("a")
    assert node.master.call_unchecked("getParam", "/nope")[::2] == [-1, 0]
    assert node.master.call_unchecked("lookupNode", "/a")[::2] == [1, node.uri]


@pytest.mark.slow
@pytest.mark.parametrize("wrong", [{"log_level": "loud"}, {"master_uri": "nonsense"}, {"callbacks": "twist"}])
def test_a_node_that_is_refused_leaves_nothing_open(environ: dict[str, str], wrong: dict[str, Any]) -> None:
    with warnings.catch_warnings(record=True) as left:
        warnings.simplefilter("always")
        with pytest.raises((ValueError, pyros1.ProtocolError)):
            pyros1.Node("a", argv=[], environ=environ, handle_signals=False, **wrong)
        gc.collect()
    assert not left


@pytest.mark.parametrize("ports", [(0, 65536), (-1, 0)], ids=str)
def test_ports_that_are_none(make_node: Any, ports: tuple[int, int]) -> None:
    with pytest.raises(OverflowError, match="port must be 0-65535"):
        make_node("a", ports=ports)


def test_what_peers_do_is_not_logged_below_the_nodes_level(make_node: Any, watch_log: Any, raw_peer: Any) -> None:
    node = make_node("a", log_level="error")
    log = watch_log(node)
    assert "no topic" in raw_peer(node).greet(callerid="/x").answer()["error"]
    node.log.level = INFO
    raw_peer(node).greet(callerid="/x").answer()
    log.saw("refused a connection from")
    assert len([text for text in log.texts if "refused" in text]) == 1


@pytest.mark.skipif(not hasattr(os, "SCHED_FIFO"), reason="only Linux has real-time priorities")
def test_a_real_time_priority(
    make_node: Any, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Feature: real-time priority of a node -- `node.realtime(50)`, `__priority:=50`, `<node priority="50">`."""
    asked: dict[int, int] = {}
    monkeypatch.setattr(
        os, "sched_setscheduler", lambda thread, policy, param: asked.update({thread: param.sched_priority})
    )
    make_node("a", argv=["__priority:=50"])
    assert set(asked.values()) == {50} and len(asked) > 1
    node = make_node("b")
    node.realtime(7)
    assert asked[threading.get_native_id()] == 7
    with pytest.raises(ValueError, match=r"realtime\(priority\) must be a whole number"):
        node.realtime(100)
    with pytest.raises(pyros1.SettingError, match=r"__priority:= must be a whole number .* not 'high'"):
        make_node("c", argv=["__priority:=high"])

    def refuse(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    with pytest.raises(pyros1.NodeError, match="the system does not permit it"):
        node.realtime(50)
    capfd.readouterr()
    assert make_node("d", argv=["__priority:=50"]).ok()
    assert "cannot get real-time priority 50: the system does not permit it" in capfd.readouterr().err


def test_spin_once_of_a_node_whose_callbacks_run_inline_has_nothing_to_do(make_node: Any) -> None:
    assert make_node("a").spin_once() == 0
