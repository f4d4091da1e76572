"""``wait-for``: nodes start when what they need exists, or it is said what did not come.

Feature: nodes that start only when a topic, service, parameter or node exists -- `wait-for="topic:/scan"`
"""

from __future__ import annotations

import queue
from collections.abc import Callable, Iterator

import pytest

from pyros1.ground.errors import LaunchError
from pyros1.launch.reading.conditions import Condition, parse_conditions, parse_seconds
from pyros1.launch.running.readiness import ConditionWatcher
from pyros1.master.server import Master
from pyros1.net.master_client import MasterClient

DEADLINE = 20.0


def test_the_attribute_is_read() -> None:
    found = parse_conditions(" topic:/scan service:x\n param:~go node:../n".replace("../", ""), "/ns/", "me")
    assert [str(one) for one in found] == ["topic:/scan", "service:/ns/x", "param:/ns/me/go", "node:/ns/n"]
    assert parse_conditions("", "/", "me") == []
    for text in ("/scan", "topic:", "action:/x", "topic:/"):
        with pytest.raises(LaunchError, match="'wait-for' has the invalid condition"):
            parse_conditions(text, "/", "me")


def test_seconds_are_read() -> None:
    assert parse_seconds("1.5", "wait-timeout") == 1.5
    for text in ("x", "-1", "inf", "nan"):
        with pytest.raises(LaunchError, match="wait-timeout"):
            parse_seconds(text, "wait-timeout")


@pytest.fixture
def client() -> Iterator[MasterClient]:
    master = Master(port=0, bind_host="127.0.0.1", advertised_host="localhost")
    master.start()
    client = MasterClient("/someone", master.uri)
    yield client
    client.close()
    master.stop()


@pytest.fixture
def done(client: MasterClient) -> queue.SimpleQueue[Callable[[], object]]:
    return queue.SimpleQueue()


@pytest.fixture
def gate(client: MasterClient, done: queue.SimpleQueue[Callable[[], object]]) -> Iterator[ConditionWatcher]:
    gate = ConditionWatcher(client.uri, done.put)
    yield gate
    gate.close()


def test_nodes_start_when_everything_is_there(
    gate: ConditionWatcher, client: MasterClient, done: queue.SimpleQueue[Callable[[], object]]
) -> None:
    said: list[str] = []
    kinds = {"topic": "/t", "service": "/s", "param": "/p", "node": "/someone"}
    for kind, name in kinds.items():
        gate.add([Condition(kind, name)], 0, lambda kind=kind: said.append(kind), said.append)
    gate.add([Condition(kind, name) for kind, name in kinds.items()], 0, lambda: said.append("all"), said.append)
    client.set_param("/p", {"a": 1})
    done.get(timeout=DEADLINE)()
    assert said == ["param"]
    client.register_publisher("/t", "std_msgs/String", "http://localhost:1/")
    for _ in range(2):
        done.get(timeout=DEADLINE)()
    assert said == ["param", "topic", "node"]
    client.register_service("/s", "rosrpc://localhost:1", "http://localhost:1/")
    for _ in range(2):
        done.get(timeout=DEADLINE)()
    assert said == ["param", "topic", "node", "service", "all"]


def test_what_did_not_come_is_named(
    gate: ConditionWatcher, client: MasterClient, done: queue.SimpleQueue[Callable[[], object]]
) -> None:
    said: list[str] = []
    client.set_param("/p", 1)
    needs = [Condition("param", "/p"), Condition("topic", "/t"), Condition("service", "/s")]
    gate.add(needs, 0.01, lambda: said.append("ready"), said.append)
    done.get(timeout=DEADLINE)()
    assert said == ["topic:/t, service:/s"]


def test_a_master_that_does_not_answer_is_no_end() -> None:
    done: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()
    gate = ConditionWatcher("http://127.0.0.1:1/", done.put)
    said: list[str] = []
    gate.add([Condition("param", "/p")], 0.01, lambda: said.append("ready"), said.append)
    done.get(timeout=DEADLINE)()
    gate.close()
    assert said == ["param:/p"]
