"""The views behind the tables: rates, publishing, parameters, dynamic_reconfigure, actions."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.actions import SimpleServer
from pyros1.ground.errors import Error
from pyros1.msgs.actionlib_tutorials.msg import FibonacciAction, FibonacciFeedback, FibonacciResult
from pyros1.msgs.dynamic_reconfigure.msg import Config, ConfigDescription, Group, GroupState, ParamDescription
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.reconfigure import Parameters, Server
from pyros1.web import calls
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError
from pyros1.web.views import reconfigure

PATIENCE = 20.0
Make = Callable[..., Any]


def test_rates_of_topics_that_nobody_else_hears(make_node: Make, watch: Make) -> None:
    publisher = make_node("quiet").advertise("/quiet", Float64)
    watched = watch("rates", topics=["/quiet", "/nobody"])
    assert publisher.wait_for_subscribers(timeout=PATIENCE)
    for _ in range(100):
        publisher.publish(Float64(1.0))
    found = watched.until(lambda data: data["/quiet"]["hz"])
    assert found["/quiet"]["bytes"] == pytest.approx(found["/quiet"]["hz"] * 8)
    assert found["/nobody"] == {"hz": None, "bytes": None}  # it may be a slow one
    watched.view.change({"topics": []})
    assert watched.view.poll() is None


def test_rates_name_what_cannot_be_seen(make_robot: Make, watch: Make) -> None:
    narrow = make_robot(topics=("/camera/*",))
    found = watch("rates", narrow, topics=["/secret"]).until(lambda data: True)
    assert "this server does not show" in found["/secret"]["problem"]
    with pytest.raises(RequestError):
        watch("rates", topics=["/t"] * 51)


def test_publishing_at_a_rate_lasts_as_long_as_the_view(make_node: Make, watch: Make) -> None:
    came: list[float] = []
    more = threading.Event()

    def has_data(message: Any) -> None:
        came.append(message.data)
        if message.data == 2.0:
            more.set()

    subscriber = make_node("ear").subscribe("/t", Float64, has_data)
    args = {"topic": "/t", "type": "std_msgs/Float64", "value": {"data": 1}, "hz": 200}
    watched = watch("publish", **args)
    watched.until(lambda data: data["sent"] > 3 and data["subscribers"] == 1)
    watched.view.change({**args, "value": {"data": 2}})
    assert more.wait(PATIENCE) and came[0] == 1.0
    watched.view.change({**args, "value": {"data": "x"}})
    watched.until(lambda data: data["problem"])
    watched.view.close()
    count = len(came)
    assert subscriber.num_connections <= 1 and len(came) == count


def test_publishing_at_a_rate_is_refused(make_robot: Make, watch: Make) -> None:
    args = {"topic": "/t", "type": "std_msgs/Float64", "value": {}}
    with pytest.raises(RequestError, match="hz must be a number"):
        watch("publish", **args, hz=1e9)
    with pytest.raises(RequestError, match="this server does not show"):
        watch("publish", make_robot(topics=("/a",)), **args)
    with pytest.raises(RequestError, match="read-only"):
        watch("publish", make_robot(read_only=True), **args)


def test_parameters_and_what_others_change(make_node: Make, watch: Make, robot: Robot) -> None:
    node = make_node("setter")
    node.params["/a/b"] = 1
    watched = watch("params")
    first = watched.until(lambda data: data["all"])
    assert first["set"]["/a/b"] == ("int", "1", False)
    node.params["/a/b"] = "x"
    node.params["/a/c"] = [1, 2]
    found = watched.until(lambda data: "/a/c" in data["set"])
    assert not found["all"] and found["set"]["/a/c"] == ("list", "[1, 2]", False)
    calls.run(robot, "params.delete", {"name": "/a"})
    assert "/a/c" in watched.until(lambda data: data["gone"])["gone"]


def test_dynamic_reconfigure_both_ways(make_node: Make, watch: Make, robot: Robot) -> None:
    parameters = Parameters()
    parameters.add("rate", 10.0, "Hz", minimum=0.5, maximum=100)
    parameters.add("gain", 1.0)
    parameters.add("mode", 0, choices={"Slow": 0, "Fast": 1})
    node = make_node("motor")
    server = Server(node, parameters, lambda config, level: config)
    watched = watch("reconfigure", node="/motor")
    shown = watched.until(lambda data: True)
    by_name = {each["name"]: each for each in shown["parameters"]}
    assert (by_name["rate"]["min"], by_name["rate"]["max"], by_name["gain"]["max"]) == (0.5, 100.0, None)
    assert by_name["mode"]["choices"] == [["Slow", 0], ["Fast", 1]]
    assert shown["values"] == {"rate": 10.0, "gain": 1.0, "mode": 0}
    types = {each["name"]: each["type"] for each in shown["parameters"]}
    args = {"node": "/motor", "values": {"rate": 20, "mode": 1}, "types": types}
    assert calls.run(robot, "reconfigure.update", args)["rate"] == 20.0
    watched.until(lambda data: data["values"] == {"rate": 20.0, "gain": 1.0, "mode": 1})
    server.update({"gain": 3.0})
    watched.until(lambda data: data["values"]["gain"] == 3.0)
    for wrong in ({"values": {"rate": "x"}}, {"types": {}}, {"values": []}):
        with pytest.raises(RequestError):
            calls.run(robot, "reconfigure.update", {**args, **wrong})


def test_groups_of_dynamic_reconfigure(make_node: Make, watch: Make) -> None:
    parameters = Parameters()
    parameters.add("top", 1)
    outer = parameters.group("outer")
    outer.add("first", 1)
    parameters.group("inner", parent=outer).add("second", 2)
    Server(make_node("motor"), parameters, lambda config, level: config)
    shown = watch("reconfigure", node="/motor").until(lambda data: True)
    groups = {each["name"]: each["groups"] for each in shown["parameters"]}
    assert groups == {"top": [], "first": ["outer"], "second": ["outer", "inner"]}


def test_groups_that_the_node_closes_and_hides() -> None:
    kinds = {1: "collapse", 2: "hide", 3: "collapse", 4: ""}
    groups = [
        Group(name=f"g{number}", id=number, parent=1 if number == 2 else 0, type=kinds[number]) for number in kinds
    ]
    states = [GroupState(id=number, state=number == 3) for number in kinds]
    both = ConfigDescription(groups=groups), Config(groups=states)
    found = reconfigure.groups(*both)
    assert [(each["type"], each["path"]) for each in found if not each["state"]] == [
        ("collapse", ["g1"]),
        ("hide", ["g1", "g2"]),
        ("", ["g4"]),
    ]
    assert found[1] == {"path": ["g1", "g2"], "type": "hide", "name": "g2", "state": False, "id": 2, "parent": 1}
    assert all(each["state"] for each in reconfigure.groups(both[0], Config()))


def test_groups_are_turned_on_and_off(make_node: Make, watch: Make, robot: Robot) -> None:
    parameters = Parameters()
    for name in ("a", "b"):
        parameters.group(name, type="collapse").add(f"in_{name}", 1)
    Server(make_node("motor"), parameters, lambda config, level: config)
    watched = watch("reconfigure", node="/motor")
    groups = watched.until(lambda data: True)["groups"]
    states = [{key: each[key] for key in ("name", "id", "parent")} | {"state": each["name"] != "a"} for each in groups]
    calls.run(robot, "reconfigure.turn", {"node": "/motor", "groups": states})
    closed = watched.until(lambda data: [each["path"] for each in data["groups"] if not each["state"]] == [["a"]])
    assert closed["values"] == {"in_a": 1, "in_b": 1}
    for wrong in (None, [1], [{"state": "x"}], [{"id": 2**40}]):
        with pytest.raises(Error, match="groups"):
            calls.run(robot, "reconfigure.turn", {"node": "/motor", "groups": wrong})


def test_groups_that_go_round_in_circles() -> None:
    message = ConfigDescription(groups=[Group(name="a", id=1, parent=2), Group(name="b", id=2, parent=1)])
    message.groups[0].parameters = [ParamDescription(name="x", type="int")]
    assert reconfigure.parameters(message)[0]["groups"] == ["b", "a"]


def test_goals_of_an_action(make_node: Make, watch: Make, robot: Robot) -> None:
    go_on = threading.Event()

    def execute(goal: Any) -> Any:
        until = time.monotonic() + PATIENCE
        while not go_on.wait(0.1):  # who looks may come later than the goal
            assert time.monotonic() < until
            goal.feedback(FibonacciFeedback(sequence=[0, 1]))
        if goal.cancel_requested:
            goal.cancel(FibonacciResult(sequence=[9]))
            return None
        return FibonacciResult(sequence=[0, 1, goal.goal.order])

    with SimpleServer(make_node("counter"), "fibonacci", FibonacciAction, execute):
        watched = watch("action", action="/fibonacci")
        form = patiently(lambda: calls.run(robot, "actions.form", {"action": "/fibonacci"}))
        assert form["type"] == "actionlib_tutorials/FibonacciGoal" and form["fields"] == [
            ["order", "int32", None, None]
        ]
        sent = calls.run(robot, "actions.send", {"action": "/fibonacci", "value": {"order": 7}})
        assert sent["subscribers"] == 1  # it has waited for them
        going = watched.until(lambda data: data["goals"] and data["goals"][0]["feedback"])["goals"][0]
        assert going["id"] == sent["id"] and going["feedbacks"] >= 1
        go_on.set()
        done = watched.until(lambda data: data["goals"][0]["result"] and data["goals"][0]["status"] == 3)["goals"][0]
        assert done["result"]["fields"][0][2]["items"] == [0, 1, 7]
        go_on.clear()
        second = calls.run(robot, "actions.send", {"action": "/fibonacci", "value": {}})
        watched.until(lambda data: any(goal["id"] == second["id"] and goal["status"] == 1 for goal in data["goals"]))
        calls.run(robot, "actions.cancel", {"action": "/fibonacci", "id": second["id"]})
        watched.until(lambda data: data["goals"][0]["status"] == 6)
        go_on.set()
        watched.until(lambda data: data["goals"][0]["status"] == 2)


def test_topics_of_an_actions_names_but_other_types(make_node: Make, watch: Make) -> None:
    publisher = make_node("other").advertise("/x/status", Float64, latch=True)
    publisher.publish(Float64(1.0))
    watched = watch("action", action="/x")
    with pytest.raises(RequestError, match="this is not an action"):
        watched.until(lambda data: False)


def patiently(ask: Callable[[], Any]) -> Any:
    """Return what a call returns as soon as the master knows what it is about."""
    deadline = time.monotonic() + PATIENCE
    while True:
        try:
            return ask()
        except RequestError:
            assert time.monotonic() < deadline
            threading.Event().wait(0.05)
