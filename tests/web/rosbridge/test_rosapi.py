"""The services of rosapi."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.ground.errors import Error
from pyros1.msgs import AnyMsg, load_message
from pyros1.msgs.rospy_tutorials.srv import AddTwoInts
from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.web.robot import Robot
from pyros1.web.rosbridge import rosapi


@pytest.fixture
def ask(robot: Robot, make_node: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that asks about a robot with a node /one."""
    node = make_node("one")
    node.advertise("number", Float64)
    node.subscribe("words", String, lambda message: None)
    node.advertise_service("add", AddTwoInts, lambda request: 0)
    for end in ("Goal", "Result", "Feedback"):
        node.advertise(f"/act/{end.lower()}", f"actionlib_tutorials/FibonacciAction{end}")

    def ask(name: str, /, *args: Any, **fields: Any) -> Any:
        return rosapi.run(robot, "/rosapi/" + name, list(args) or fields or None)

    return ask


def test_topics(ask: Callable[..., Any]) -> None:
    found = ask("topics")
    types = dict(zip(found["topics"], found["types"], strict=True))
    assert (types["/number"], types["/words"]) == ("std_msgs/Float64", "std_msgs/String")
    raw = ask("topics_and_raw_types")
    texts = dict(zip(raw["topics"], raw["typedefs_full_text"], strict=True))
    assert texts["/number"] == Float64._full_text
    assert ask("topics_for_type", type="std_msgs/String") == {"topics": ["/words"]}
    assert ask("topic_type", "/words") == {"type": "std_msgs/String"}
    assert ask("topic_type", topic="/none") == {"type": ""}
    assert ask("publishers", topic="/number") == {"publishers": ["/one"]}
    assert ask("subscribers", topic="/words") == {"subscribers": ["/one"]}
    assert ask("action_servers") == {"action_servers": ["/act"]}


@pytest.mark.parametrize(
    ("topic", "kind"),
    [
        ("/number/data", "std_msgs/Float64"),
        ("/number/", "std_msgs/Float64"),
        ("/act/goal/header/stamp", "actionlib_tutorials/FibonacciActionGoal"),
        ("/numbers", ""),
        ("/act/nothing", ""),
        ("/" * 10_000, ""),
    ],
)
def test_the_type_of_a_topic_for_a_field_of_it(ask: Callable[..., Any], topic: str, kind: str) -> None:
    assert ask("topic_type", topic=topic) == {"type": kind}


def test_fields_of_hidden_topics(make_robot: Callable[..., Robot], make_node: Callable[..., Any]) -> None:
    make_node("one").advertise("/hidden", Float64)
    robot = make_robot(topics=("/hidden/*",))
    assert rosapi.run(robot, "/rosapi/topic_type", {"topic": "/hidden/data"}) == {"type": ""}


def test_lists_of_arguments_may_be_shorter_or_longer(ask: Callable[..., Any]) -> None:
    assert ask("get_param", "/unset") == {"value": "null"}
    assert ask("get_param", "/unset", "5", "more") == {"value": "5"}
    assert ask("nodes", "more") == ask("nodes")


@pytest.mark.parametrize("args", [None, [], {}, "x", 5, True, 1.5])
def test_other_values_count_as_no_arguments(robot: Robot, args: Any) -> None:
    assert rosapi.run(robot, "/rosapi/topic_type", args) == {"type": ""}
    assert rosapi.run(robot, "/rosapi/topics", args)["topics"]


def test_services(ask: Callable[..., Any]) -> None:
    assert "/add" in ask("services")["services"]
    assert ask("service_type", service="/add") == {"type": "rospy_tutorials/AddTwoInts"}
    assert ask("services_for_type", type="rospy_tutorials/AddTwoInts") == {"services": ["/add"]}
    assert ask("service_providers", service="/add") == {"providers": ["/one"]}
    assert ask("service_providers", service="rospy_tutorials/AddTwoInts") == {"providers": ["/one"]}
    assert ask("service_node", service="/add") == {"node": "/one"}
    assert ask("service_host", service="/add")["host"]


@pytest.mark.parametrize("service", ["/none", "", "not a name", "rospy_tutorials/AddTwoInts"])
def test_services_that_nobody_provides(ask: Callable[..., Any], service: str) -> None:
    assert ask("service_type", service=service) == {"type": ""}
    assert ask("service_host", service=service) == {"host": ""}
    assert ask("service_node", service=service) == {"node": ""}


def test_nothing_is_of_the_empty_type(ask: Callable[..., Any], robot: Robot, make_node: Callable[..., Any]) -> None:
    make_node("two").subscribe("anything", AnyMsg, lambda message: None)
    robot.master.register_service("/gone", "rosrpc://localhost:1", "http://localhost:1")
    assert ask("service_type", service="/gone") == {"type": ""}
    assert ask("topics_for_type", type="") == {"topics": []}
    assert ask("services_for_type", type="") == {"services": []}
    assert ask("service_providers", service="") == {"providers": []}


def test_nodes(ask: Callable[..., Any]) -> None:
    assert "/one" in ask("nodes")["nodes"]
    details = ask("node_details", node="/one")
    assert "/number" in details["publishing"]
    assert details["subscribing"] == ["/words"]
    assert "/add" in details["services"]
    assert ask("node_details", node="/none") == {"subscribing": [], "publishing": [], "services": []}
    assert ask("get_time")["time"]["secs"] > 0


@pytest.mark.parametrize("value", [1, 2.5, True, "x", "ä", [1, [2]], {"a": {"b": 1}}])
def test_parameters(ask: Callable[..., Any], value: Any) -> None:
    assert ask("has_param", name="/p") == {"exists": False}
    assert ask("get_param", name="/p") == {"value": "null"}
    assert ask("get_param", name="/p", default="5") == {"value": "5"}
    ask("set_param", name="/p", value=json.dumps(value))
    assert json.loads(ask("get_param", name="/p")["value"]) == value
    assert ask("has_param", name="/p") == {"exists": True}
    assert any(name.startswith("/p") for name in ask("get_param_names")["names"])
    assert ask("search_param", name="p") == {"global_name": "/p"}
    ask("delete_param", name="/p")
    assert ask("search_param", name="p") == {"global_name": ""}


def test_parameters_whose_names_break_the_grammar(ask: Callable[..., Any], robot: Robot) -> None:
    assert ask("get_param", name="a b", default="x") == {"value": '"x"'}
    assert ask("has_param", name="a b") == {"exists": False}
    ask("set_param", name="a b", value="1")
    assert ask("get_param", name="a b") == {"value": "1"}
    ask("delete_param", name="a b")
    ask("delete_param", name="a b")  # as often as one likes
    assert ask("search_param", name="") == {"global_name": ""}
    robot.master.set_param("/kept", 1)
    for value in ("{}", "1"):
        with pytest.raises(Error):
            ask("set_param", name="/", value=value)
    assert ask("has_param", name="/kept") == {"exists": True}


@pytest.mark.parametrize("value", ["", "{", "1" * 5000, str(1 << 40), "null", "NaN", '"\\ud800"', "[" * 10_000])
def test_values_that_no_parameter_can_have(ask: Callable[..., Any], value: str) -> None:
    try:
        ask("set_param", name="/p", value=value)
    except Error:
        return
    ask("get_param", name="/p")


def test_definitions(ask: Callable[..., Any]) -> None:
    header, time, pose, *others = ask("message_details", type="geometry_msgs/PoseStamped")["typedefs"][1:]
    assert header["type"] == "std_msgs/Header"
    assert header["fieldnames"] == ["seq", "stamp", "frame_id"]
    assert header["fieldtypes"] == ["uint32", "time", "string"]
    assert header["fieldarraylen"] == [-1, -1, -1]
    assert header["examples"] == ["0", "{}", ""]
    assert (time["type"], time["fieldnames"]) == ("time", ["secs", "nsecs"])
    assert [each["type"] for each in (pose, *others)] == [
        "geometry_msgs/Pose",
        "geometry_msgs/Point",
        "geometry_msgs/Quaternion",
    ]
    imu = ask("message_details", type="sensor_msgs/Imu")["typedefs"][0]
    lengths = dict(zip(imu["fieldnames"], imu["fieldarraylen"], strict=True))
    assert lengths["orientation_covariance"] == 9
    log = ask("message_details", "rosgraph_msgs/Log")["typedefs"][0]
    assert dict(zip(log["constnames"], log["constvalues"], strict=True))["FATAL"] == "16"
    request = ask("service_request_details", type="rospy_tutorials/AddTwoInts")["typedefs"][0]
    assert request["fieldnames"] == ["a", "b"]
    response = ask("service_response_details", type="rospy_tutorials/AddTwoInts")["typedefs"][0]
    assert response["fieldnames"] == ["sum"]
    assert load_message("std_msgs/Header")


@pytest.mark.parametrize(
    ("service", "fields"),
    [
        ("nothing", {}),
        ("", {}),
        ("topics/../x", {}),
        ("topic_type", {"topic": 1}),
        ("message_details", {"type": "no_msgs/Type"}),
        ("message_details", {"type": "../../etc/passwd"}),
        ("message_details", {"type": ""}),
        ("delete_param", {"name": "/"}),
    ],
)
def test_what_cannot_be_answered(ask: Callable[..., Any], service: str, fields: dict[str, Any]) -> None:
    with pytest.raises(Error):
        ask(service, **fields)
