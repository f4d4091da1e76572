"""The nodes of the package rostest, on live topics (L186)."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pyros1.ground.timing import Time
from pyros1.launch.testing.junit import Case, read_results
from pyros1.master.server import Master
from pyros1.node import Node
from pyros1.test_nodes import advertise, analyzers, hz, param, publish
from pyros1.test_nodes.common import SetupError, Test, run_case
from pyros1.test_nodes.program import main

Make = Callable[..., Node]
STRING = "std_msgs/String"


@pytest.fixture
def robot(make_node: Make) -> Node:
    """Publishes /beat, again and again, subscribes /heard and provides /ask."""
    node = make_node("robot", rosout=False)
    publisher: Any = node.advertise("/beat", STRING, queue_size=1)
    node.timer(0.02, lambda _: publisher.publish("x"))
    node.subscribe("/heard", STRING, lambda _: None)
    node.advertise_service("/ask", "std_srvs/Trigger", lambda _: (True, ""))
    return node


def cases(make: Callable[[Node], dict[str, Test]], node: Node, **params: Any) -> dict[str, Case]:
    for name, value in params.items():
        node.params[f"~{name}"] = value
    return {name: run_case(name, "", test) for name, test in make(node).items()}


def outcome(case: Case) -> str:
    return "; ".join([text for _, text in case.failures] + [f"{kind}: {text}" for kind, text in case.errors]) or "ok"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("params", "said"),
    [
        ({"topic": "beat", "hz": 500.0, "hzerror": 499.9, "test_duration": 2.0, "wall_clock": True}, "ok"),
        ({"topic": "beat", "hz": 500.0, "hzerror": 499.9, "test_duration": 2.0}, "ok"),
        ({"topic": "beat", "hz": 5000, "hzerror": 1, "test_duration": 0.3}, "below the minimum"),
        ({"topic": "beat", "hz": 0, "test_duration": 0.3}, "a message arrived on /beat"),
        ({"topic": "silence", "hz": 0, "test_duration": 0.1, "wait_time": 0.1}, "ok"),
        ({"topic": "silence", "hz": 1, "hzerror": 0, "test_duration": 0.1, "wait_time": 0.1}, "no message on /silence"),
        ({"topic": "beat", "hz": 1}, "not set: /check/test_duration"),
        ({"topic": "beat", "hz": 1, "test_duration": 1}, "not set: /check/hzerror"),
        ({"topic": "beat", "hz": -1, "hzerror": 0, "test_duration": 1}, "~hz must not be negative"),
        ({"topic": "beat", "hz": 1, "hzerror": -1, "test_duration": 1}, "~hzerror must not be negative"),
        ({"topic": "beat", "hz": 1, "hzerror": 0, "test_duration": 0}, "~test_duration must be greater than 0"),
        ({"topic": "", "hz": 1, "hzerror": 0, "test_duration": 1}, "~topic is empty"),
        ({"topic": "beat", "hz": "x", "test_duration": 1}, "ValueError: could not convert"),
        ({"topic": "a b", "hz": 1, "hzerror": 0, "test_duration": 1}, "InvalidNameError: "),
    ],
)
def test_hztest(make_node: Make, robot: Node, params: dict[str, Any], said: str) -> None:
    assert said in outcome(cases(hz.tests, make_node("check"), **params)["test_hz"])


def test_a_test_that_is_told_to_end_has_found_nothing(make_node: Make) -> None:
    node = make_node("check")
    publisher = make_node("other").advertise("silence", STRING)

    def shut_down() -> None:
        publisher.wait_for_subscribers(timeout=20)
        node.shutdown()

    thread = threading.Thread(target=shut_down)
    thread.start()
    (case,) = cases(hz.tests, node, topic="silence", hz=1, hzerror=0, test_duration=20).values()
    thread.join()
    assert outcome(case) == "Error: the test was interrupted"


def test_paramtest(make_node: Make) -> None:
    def check(**params: Any) -> str:
        node = make_node("check")
        (case,) = cases(param.tests, node, wait_time=0.1, **params).values()
        node.shutdown()
        return outcome(case)

    make_node("other").params["/there"] = "yes"
    assert check(param_name_target="/there") == "ok"
    assert check(param_name_target="there", param_value_expected="yes") == "ok"
    assert check(param_name_target="/there", param_value_expected="no") == "/there should be 'no', but is 'yes'"
    assert check(param_name_target="/there", param_value_expected=0) == "ok"
    assert check(param_name_target="/none", param_value_expected=0) == "/none was not set within 0.1 s"


def test_paramtest_of_nothing(make_node: Make) -> None:
    assert outcome(cases(param.tests, make_node("check"))["test_param"]) == "not set: /check/param_name_target"


@pytest.mark.parametrize(
    ("topics", "said"),
    [
        ([{"name": "beat"}, {"name": "silence", "timeout": 0.1, "negative": True}], "ok"),
        ([{"name": "silence", "timeout": 0.1}], "no message arrived on silence within 0.1 s"),
        ([{"name": "/beat", "negative": True}], "a message arrived on /beat"),
        ([{"name": "beat", "timeout": "soon"}], "ValueError: could not convert"),
    ],
)
def test_publishtest(make_node: Make, robot: Node, topics: list[Any], said: str) -> None:
    assert said in outcome(cases(publish.tests, make_node("check"), topics=topics)["test_publish"])


def test_analyzer_loader(make_node: Make) -> None:
    good = {"type": "diagnostic_aggregator/GenericAnalyzer", "path": "A", "contains": "a"}
    for names, said in (("a", "ok"), ("", "has no analyzers"), ("ab", "b is ignored: it has no path")):
        node = make_node(f"loader_{names}")
        found = {name: good if name == "a" else {**good, "path": 1} for name in names}
        case = cases(analyzers.tests, node, analyzers=found)["analyzerLoading"]
        assert said in outcome(case)


def test_publishtest_in_simulated_time(make_node: Make, robot: Node) -> None:
    """The time of a topic is over when the clock says so."""
    robot.params["/use_sim_time"] = True
    clock: Any = robot.advertise("/clock", "rosgraph_msgs/Clock", queue_size=1)
    seconds = iter(range(1, 10**6))
    robot.timer(0.01, lambda _: clock.publish(Time(next(seconds), 0)))
    topics = [{"name": "silence", "timeout": 60, "negative": True}, {"name": "beat", "timeout": 10**6}]
    assert outcome(cases(publish.tests, make_node("check"), topics=topics)["test_publish"]) == "ok"


def test_a_clock_that_does_not_tick(make_node: Make, robot: Node, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.test_nodes.common.CLOCK_TIMEOUT", 0.1)
    robot.params["/use_sim_time"] = True
    (case,) = cases(publish.tests, make_node("check"), topics=[{"name": "beat"}]).values()
    assert "no message arrived on /clock" in outcome(case)


@pytest.mark.parametrize(
    ("topics", "services", "said"),
    [
        ([{"name": "/beat", "type": STRING}], [], "ok"),
        ([{"name": "/none", "timeout": 0.1, "negative": True}], [], "ok"),
        ([{"name": "/beat", "type": "std_msgs/Bool"}], [], "/beat should be of type std_msgs/Bool, but is of type"),
        ([{"name": "/beat", "negative": True}], [], "/beat exists, but should not"),
        ([{"name": "/heard", "timeout": 0.1}], [], "/heard did not appear within 0.1 s"),
        ([], [{"name": "/ask", "type": "std_srvs/Trigger"}], "ok"),
        ([], [{"name": "/ask", "type": "std_srvs/Empty"}], "/ask should be of type std_srvs/Empty"),
        ([], [{"name": "/ask", "negative": True}], "/ask exists, but should not"),
        ([], [{"name": "/none", "timeout": 0.1}], "/none did not appear"),
    ],
)
def test_advertisetest(make_node: Make, robot: Node, topics: list[Any], services: list[Any], said: str) -> None:
    found = cases(advertise.advertise_tests, make_node("check"), topics=topics, services=services)
    assert list(found) == ["test_advertise_services", "test_advertise_topics"]
    mine, other = sorted((outcome(case) for case in found.values()), key=lambda text: text == "ok")
    assert mine.startswith(said)
    assert other == "ok"


@pytest.mark.parametrize(
    ("topic", "said"),
    [
        ({"name": "/heard", "type": STRING}, "ok"),
        ({"name": "/heard", "negative": True}, "/heard exists, but should not"),
        ({"name": "/beat", "timeout": 0.1}, "/beat did not appear within 0.1 s"),
    ],
)
def test_subscribetest(make_node: Make, robot: Node, topic: dict[str, Any], said: str) -> None:
    (case,) = cases(advertise.subscribe_tests, make_node("check"), topics=[topic]).values()
    assert outcome(case) == said


@pytest.mark.parametrize("make", [publish.tests, advertise.advertise_tests, advertise.subscribe_tests])
@pytest.mark.parametrize("topics", [[], [{"timeout": 1}], "/beat", 5])
def test_nothing_to_test(make_node: Make, make: Callable[[Node], Any], topics: Any) -> None:
    with pytest.raises(SetupError):
        cases(make, make_node("check"), topics=topics)


def test_the_program(
    master: Master, environ: dict[str, str], make_node: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Results go where rostest wants them; a node that was not told what to test leaves none."""
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    file = tmp_path / "results" / "it.xml"
    words = ["/somewhere/paramtest", f"--gtest_output=xml:{file}", "__name:=it"]
    assert main(words) == 1
    (case,) = read_results(file, "s").cases
    assert (case.name, case.classname, outcome(case)) == (
        "s/test_param",
        "__main__.ParamTest",
        "not set: /it/param_name_target",
    )
    assert main([*words, "_param_name_target:=/it/param_name_target"]) == 0
    assert read_results(file, "s").failures == 0
    file.unlink()
    assert main([*words, "_param_name_target:=/none", "_wait_time:=0", "--text"]) == 1
    assert main(["/somewhere/publishtest", *words[1:]]) == 1
    assert not file.exists()
