"""The pure checks, with facts that one machine cannot show: several machines, names that resolve wrongly."""

from __future__ import annotations

from typing import Any

import pytest

from pyros1.doctor.connectivity_checks import check_connectivity
from pyros1.doctor.edges import Edge, actual_edges, expected_edges
from pyros1.doctor.facts import REFUSED, TIMEOUT, Failure, LocalProcess, Machine, NodeFacts, System
from pyros1.doctor.finding import Finding
from pyros1.doctor.local_facts import setting_problems
from pyros1.doctor.machine_checks import check_machine
from pyros1.doctor.topic_checks import check_topics, missing_edges, similar_topic_name
from pyros1.graph import Connection, SystemState, parse_bus_entry

HERE = "192.0.2.7"


def machine(environ: dict[str, str], **facts: Any) -> Machine:
    facts.setdefault("interfaces", ["127.0.0.1", HERE])
    return Machine(environ, **facts)


def kinds(findings: list[Finding]) -> dict[str, Finding]:
    return {finding.kind: finding for finding in findings}


def one_topic(nodes: dict[str, NodeFacts], **facts: Any) -> System:
    """A system in which /a publishes and /b subscribes /t."""
    state = SystemState({"/t": ["/a"]}, {"/t": ["/b"]}, {})
    return System(f"http://{HERE}:11311/", state, nodes, **facts)


def link(topic: str, direction: str, other: str, connected: bool = True) -> Connection:
    return Connection(1, other, direction, "TCPROS", topic, connected)


def test_low_latency_on_a_busy_machine() -> None:
    entry = [0, "http://a:1/", "i", "TCPROS", "/t", True, "TCPROS connection on port 5 to [a:1 on socket 3]"]
    quiet = parse_bus_entry(entry)
    entry[-1] += ", polling paused"
    busy = parse_bus_entry(entry)
    assert (busy.local_port, busy.peer, busy.socket) == ("5", "a:1", "3")
    nodes = {
        "/a": NodeFacts("http://a:1/", "a", connections=[link("/t", "o", "/b")]),
        "/b": NodeFacts("http://b:1/", "b", connections=[busy, busy, quiet]),
    }
    assert kinds(check_topics(one_topic(nodes)))["low-latency"].items == ("/b: /t",)
    nodes["/b"].connections = [quiet]
    assert "low-latency" not in kinds(check_topics(one_topic(nodes)))


def test_the_debian_trap_127_0_1_1() -> None:
    """The own name means 127.0.1.1 here and nothing elsewhere: harmless until the master is on another machine."""
    names = {"here": ["127.0.1.1"], "robot": ["192.0.2.1"]}
    assert not check_machine(machine({}, resolved=names))
    found = kinds(check_machine(machine({"ROS_MASTER_URI": "http://robot:11311"}, resolved=names)))
    assert "resolves to 127.0.1.1 here" in found["own-name"].text and found["own-name"].fix == f"export ROS_IP={HERE}"


@pytest.mark.parametrize(
    ("addresses", "part"), [(None, "cannot be resolved"), (["192.0.2.99"], "which is not its address")]
)
def test_an_own_name_that_is_wrong(addresses: list[str] | None, part: str) -> None:
    found = kinds(check_machine(machine({}, resolved={"here": addresses})))
    assert part in found["own-name"].text and "/etc/hosts" in found["own-name"].fix
    assert "own-name" not in kinds(check_machine(machine({"ROS_IP": HERE}, resolved={"here": addresses, HERE: [HERE]})))


def test_both_variables_and_an_old_python() -> None:
    found = kinds(check_machine(machine({"ROS_IP": HERE, "ROS_HOSTNAME": "x"}, resolved={"x": [HERE]}, python=(3, 8))))
    assert found["both-set"].severity == "warning" and "3.8" in found["python"].text


def test_settings_with_which_no_node_starts() -> None:
    wrong = {"PYROS1_ALLOW": "robot", "PYROS1_BIND": "192.0.2.77", "PYROS1_PORTS": "5-1", "PYROS1_TRANSPORTS": "udp"}
    problems = setting_problems(wrong)
    assert [problem[: len(name)] for problem, name in zip(problems, wrong, strict=True)] == list(wrong)
    assert not setting_problems({"PYROS1_ALLOW": "10.0.0.0/8", "PYROS1_PORTS": "5-9", "PYROS1_TRANSPORTS": "tcp"})
    found = [each for each in check_machine(machine(wrong, setting_problems=problems)) if each.kind == "setting"]
    assert len(found) == 4 and found[2].severity == "error" and "PYROS1_PORTS is '5-1'" in found[2].text


def test_programs_of_another_master_are_named_but_not_all() -> None:
    processes = [LocalProcess(number, "talker", "http://robot:11311", "") for number in range(12)]
    processes.append(LocalProcess(99, "mine", "http://127.0.0.1:11311/", ""))
    items = kinds(check_machine(machine({}, processes=processes)))["other-master-uri"].items
    assert items[0] == "talker (pid 0): http://robot:11311" and items[-1] == "and 2 more" and len(items) == 11


def test_one_master_under_two_names_is_one() -> None:
    processes = [LocalProcess(1, "core", "http://robot:11311", ""), LocalProcess(2, "far", "http://other:11311", "")]
    known = {"robot": [HERE], "other": ["192.0.2.9"], HERE: [HERE]}
    found = kinds(
        check_machine(machine({"ROS_MASTER_URI": f"http://{HERE}:11311"}, processes=processes, resolved=known))
    )
    assert found["other-master-uri"].items == ("far (pid 2): http://other:11311",)


def test_a_loopback_address_in_a_system_of_several_machines() -> None:
    nodes = {
        "/a": NodeFacts("http://localhost:1/", "localhost", ["127.0.0.1"]),
        "/b": NodeFacts("http://192.0.2.1:2/", "192.0.2.1", ["192.0.2.1"]),
    }
    found = kinds(check_connectivity(one_topic(nodes), machine({})))["loopback-node"]
    assert found.items == ("/a (http://localhost:1/)",) and "/b" in found.text and "127.0.1.1" in found.fix
    nodes["/b"].failure = Failure(TIMEOUT, "")  # perhaps it is here, and its address is wrong
    assert "loopback-node" not in kinds(check_connectivity(one_topic(nodes), machine({})))
    nodes["/b"] = NodeFacts("http://192.0.2.1:2/", "192.0.2.1", [HERE])
    assert not check_connectivity(one_topic(nodes), machine({}))


def test_the_process_that_gave_a_wrong_address_is_named() -> None:
    nodes = {"/a": NodeFacts("http://192.0.2.99:1/", "192.0.2.99", ["192.0.2.99"], Failure(TIMEOUT, ""))}
    here = machine({}, processes=[LocalProcess(7, "talker", "", "192.0.2.99")])
    assert f"(here: {HERE}; talker, pid 7)" in kinds(check_connectivity(one_topic(nodes), here))["unreachable-host"].fix


@pytest.mark.parametrize(("offset", "found"), [(0.9, False), (-3.0, True), (7200.0, True), (None, False)])
def test_clocks(offset: float | None, found: bool) -> None:
    nodes = {"/a": NodeFacts("http://r:1/", "r", [HERE], clock_offset=offset)}
    assert ("clock-skew" in kinds(check_connectivity(one_topic(nodes), machine({})))) is found


@pytest.mark.parametrize(
    ("topic", "others", "near"),
    [
        ("/cmd_vel", ["/cmd_val", "/scan"], "/cmd_val"),
        ("/scan", ["/robot1/scan", "/odom"], "/robot1/scan"),
        ("/scan", ["/robot1/scan", "/robot2/scan"], None),
        ("/image", ["/camera_info"], None),
        ("/image", [], None),
    ],
)
def test_near_misses(topic: str, others: list[str], near: str | None) -> None:
    assert similar_topic_name(topic, others) == near


def test_edges() -> None:
    a, b = NodeFacts("http://h:1/", "h"), NodeFacts("http://h:2/", "h")
    system = one_topic({"/a": a, "/b": b})
    edge = Edge("/t", "/a", "/b")
    assert expected_edges(system.state) == [edge] == missing_edges(system)
    b.connections = [link("/t", "i", "http://h:1")]
    assert missing_edges(system) == [edge]  # one end is not enough
    a.connections = [link("/t", "o", "/b")]
    assert missing_edges(system) == [] and not check_topics(system)
    a.connections = [link("/t", "o", "/b", connected=False)]
    assert missing_edges(system) == [edge]
    b.failure = Failure(REFUSED, "")
    assert missing_edges(system) == []  # what is wrong with it is said elsewhere
    told = actual_edges({"/b": [link("/t", "i", "http://gone:1/")]}, {"/b": "http://h:2/"})
    assert told == {"/b": {Edge("/t", "http://gone:1/", "/b")}}


def test_a_node_may_hear_itself_through_memory() -> None:
    node = NodeFacts("http://h:1/", "h", connections=[link("/t", "o", "/a")])
    state = SystemState({"/t": ["/a"]}, {"/t": ["/a"]}, {})
    assert missing_edges(System("http://h:3/", state, {"/a": node})) == []
