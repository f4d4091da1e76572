"""The node rosapi, and those who call its services."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from pyros1.ground.errors import ServiceError
from pyros1.msgs import load_service
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.node import Node
from pyros1.web import rosapi_node
from pyros1.web.rosbridge import rosapi

PATIENCE = 20.0


@pytest.fixture
def ask(make_node: Callable[..., Node]) -> Callable[..., Any]:
    """Return a function that calls a service of rosapi."""
    rosapi_node.start(make_node("rosapi", argv=["_topics_glob:=[/number, /words]"]))
    user = make_node("user")
    user.advertise("number", Float64)
    user.advertise("hidden", Float64)

    def call(name: str, /, **fields: str) -> Any:
        cls = load_service(rosapi_node.service_type(name))
        with user.service(f"/rosapi/{name}", cls) as client:
            return client.call(cls._request_class(**fields), PATIENCE)

    return call


def test_services(ask: Callable[..., Any]) -> None:
    """Feature: the rosapi services for nodes: rosapi_node"""
    topics = ask("topics")
    assert (topics.topics, topics.types) == (["/number"], ["std_msgs/Float64"])
    assert ask("topic_type", topic="/number").type == "std_msgs/Float64"
    assert {"/rosapi", "/user"} <= {*ask("nodes").nodes}
    assert "/rosapi/topics" in ask("services").services
    assert ask("set_param", name="/speed", value="0.5") is not None
    assert ask("get_param", name="/speed", default="").value == "0.5"
    assert ask("get_time").time.to_sec() > 1e9
    details = ask("message_details", type="std_msgs/Float64").typedefs[0]
    assert (details.type, [*details.fieldnames], [*details.fieldarraylen]) == ("std_msgs/Float64", ["data"], [-1])
    assert ask("action_servers").action_servers == []
    with pytest.raises(ServiceError, match=r"message type \[none/None\] is unknown"):
        ask("message_details", type="none/None")


def test_all_services_have_types() -> None:
    for name in rosapi.service_names():
        response = load_service(rosapi_node.service_type(name))._response_class
        assert response.__slots__ or name in ("set_param", "delete_param")
