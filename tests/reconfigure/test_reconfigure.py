"""Servers and clients of dynamic_reconfigure in nodes; stock: interop/modules/test_dynamic_reconfigure.py."""

from __future__ import annotations

import queue
from typing import Any

import pytest

from pyros1.ground.errors import NodeError, ServiceError, SettingError, WaitTimeoutError
from pyros1.msgs.dynamic_reconfigure.msg import BoolParameter, ConfigDescription, GroupState, IntParameter, StrParameter
from pyros1.msgs.dynamic_reconfigure.msg import Config as Message
from pyros1.msgs.dynamic_reconfigure.srv import Reconfigure
from pyros1.reconfigure import CallbackError, Client, Config, ParameterError, Parameters, Server
from pyros1.reconfigure.encoding import (
    build_tree,
    decode,
    decode_description,
    encode,
    encode_description,
    groups_of,
    parameters_of,
)


@pytest.fixture
def parameters() -> Parameters:
    found = Parameters()
    found.add("rate", 10.0, "Hz", minimum=0.5, maximum=100, level=1)
    found.add("mode", 0, "of the motor", level=2, maximum=1, choices={"Slow": 0, "Fast": 1})
    lamp = found.group("Lamp", type="collapse", state=False)
    lamp.add("on", False)
    found.group("Colour", parent=lamp).add("colour", "red", level=4)
    return found


def test_descriptions(parameters: Parameters) -> None:
    assert parameters.defaults == {"rate": 10.0, "mode": 0, "on": False, "colour": "red"}
    assert parameters.min["mode"] == -(2**31) and parameters.max["rate"] == 100.0
    assert parameters.type == "" and parameters.all_level == 7
    root = parameters.config_description
    assert [(each["name"], each["id"], each["parent"]) for each in groups_of(root)] == [
        ("Default", 0, 0),
        ("Lamp", 1, 0),
        ("Colour", 2, 1),
    ]
    message = encode_description(root, parameters.max, parameters.min, parameters.defaults)
    seen = decode_description(message)
    assert [each["name"] for each in parameters_of(seen)] == list(parameters.defaults)
    assert seen["groups"]["Lamp"]["groups"]["Colour"]["parameters"][0]["default"] == "red"


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"name": "1a", "default": 1}, "naming conventions"),
        ({"name": "a", "default": [1]}, "must have a default"),
        ({"name": "a", "default": "x", "type": "int"}, "'a' has type int, but default is 'x'"),
        ({"name": "a", "default": 1, "maximum": 1.5}, "but max is 1.5"),
        ({"name": "a", "default": True, "type": "int"}, "but default is True"),
    ],
)
def test_mistakes_in_descriptions(options: dict[str, Any], error: str) -> None:
    with pytest.raises((ValueError, TypeError), match=error):
        Parameters().add(**options)


def test_configurations_have_attributes() -> None:
    config = Config(rate=1)
    config.mode = 2
    assert config == {"rate": 1, "mode": 2} == config.copy() and config.mode == 2
    assert type(config.copy()) is Config and not hasattr(config, "other")
    with pytest.raises(KeyError):
        _ = config.other


def test_messages() -> None:
    message = encode({"i": 1, "b": True, "s": "x", "d": 2.5, "d2": 3, "none": None}, {"d2": "double"})
    assert [len(each) for each in (message.ints, message.bools, message.strs, message.doubles)] == [1, 1, 1, 2]
    assert decode(message) == {"i": 1, "b": True, "s": "x", "d": 2.5, "d2": 3.0}
    with pytest.raises(ValueError, match="32 bits"):
        encode({"i": 2**40})


@pytest.mark.slow
def test_strange_trees_of_groups_end() -> None:
    circle = [GroupState("a", True, 1, 2), GroupState("b", True, 2, 1)]
    assert build_tree(circle) is None
    assert build_tree([GroupState("top", True, 0, 0), *circle])["groups"] == {}
    deep = [GroupState(str(number), True, number, max(number - 1, 0)) for number in range(50_000)]
    assert len(list(groups_of(build_tree(deep)))) == 50_000


def test_server_and_client(make_node: Any, parameters: Parameters) -> None:
    node = make_node("motor")
    node.params["~rate"] = 200.0
    calls: list[Any] = []

    def changed(config: Any, level: int) -> Any:
        calls.append((config.rate, config.mode, config.groups.groups.Lamp.state, level))
        if config.colour == "bad":
            return None
        config.colour = config.colour.upper()
        return config

    server = Server(node, parameters, changed)
    assert calls == [(100.0, 0, False, -1)]
    assert node.params["~rate"] == 100.0 and node.params["~colour"] == "RED"

    configs: queue.Queue[Any] = queue.Queue()
    client = Client(make_node("panel"), "motor", timeout=10, on_config=configs.put)
    assert configs.get(timeout=20)["rate"] == 100.0
    assert [each["name"] for each in client.description(10)] == ["rate", "mode", "on", "colour"]
    config = client.update({"mode": "fast", "rate": 0, "groups": {"Lamp": True}}, timeout=20)
    assert (config.rate, config.mode, config.groups.groups.Lamp.state) == (0.5, 1, True)
    assert config.groups.groups.Lamp.on is False
    assert configs.get(timeout=20) == config == client.config(1)
    assert calls[1] == (0.5, 1, True, 3)
    assert node.params["~mode"] == 1
    assert server.update({"mode": 0}).mode == 0
    assert calls[2][3] == 2
    with pytest.raises(ParameterError, match="don't know parameter: rates"):
        client.update({"rates": 5})
    with pytest.raises(ServiceError, match="possibly updated configuration"):
        client.update({"colour": "bad", "groups": {"Lamp": False}})
    with pytest.raises(CallbackError):
        server.update({"colour": "bad"})
    assert server.config["colour"] == "RED" and server.config["groups"]["groups"]["Lamp"]["state"] is True
    client.close()
    server.close()


def test_strange_requests(make_node: Any, parameters: Parameters) -> None:
    """Values in fields of other types, and parameters that there are not, as some clients send them."""
    node = make_node("motor")
    Server(node, parameters, lambda config, level: config, namespace="deep")
    call = make_node("panel").service("motor/deep/set_parameters", Reconfigure)
    answer = call(
        Message(ints=[IntParameter("rate", 5)], bools=[BoolParameter("mode", True)], strs=[StrParameter("x", "y")])
    )
    assert decode(answer.config) == {"rate": 5.0, "mode": 1, "on": False, "colour": "red"}
    assert node.params["~deep/rate"] == 5.0


def test_servers_that_cannot_begin(make_node: Any, parameters: Parameters) -> None:
    node = make_node("motor")
    with pytest.raises(CallbackError):
        Server(node, parameters, lambda config, level: None)
    server = Server(node, parameters, lambda config, level: config)
    with pytest.raises(NodeError, match="set_parameters"):
        Server(node, parameters, lambda config, level: config)
    assert Client(make_node("panel"), "motor", 10).update({"rate": 3}, 10).rate == 3.0
    server.close()


@pytest.mark.parametrize(("name", "value"), [("rate", "fast"), ("mode", [1]), ("mode", 1e400)])
def test_a_value_of_the_wrong_type(make_node: Any, parameters: Parameters, name: str, value: object) -> None:
    node = make_node("driver")
    node.params[f"~{name}"] = value
    with pytest.raises(SettingError, match=f"the parameter /driver/{name} must be a value of type (double|int), not "):
        Server(node, parameters, lambda config, level: config)


def test_nobody_there(make_node: Any) -> None:
    with pytest.raises(WaitTimeoutError):
        Client(make_node("panel"), "nobody", timeout=0.1)


@pytest.mark.parametrize("first", ["configuration", "description"])
def test_a_configuration_waits_for_the_description_of_its_groups(
    make_node: Any, parameters: Parameters, first: str
) -> None:
    """The two topics arrive in either order; without the description, a configuration would lack its groups."""
    node = make_node("motor")
    root = parameters.config_description
    values = {**parameters.defaults, "groups": root}
    messages = {
        "configuration": encode(values),
        "description": encode_description(root, parameters.max, parameters.min, parameters.defaults),
    }
    node.advertise_service("~set_parameters", Reconfigure, lambda request: Reconfigure._response_class())
    publishers = {
        "configuration": node.advertise("~parameter_updates", Message, latch=True),
        "description": node.advertise("~parameter_descriptions", ConfigDescription, latch=True),
    }
    configs: queue.Queue[Any] = queue.Queue()
    parameter_lists: queue.Queue[Any] = queue.Queue()
    updates: queue.Queue[Any] = queue.Queue()
    panel = make_node("panel")
    client = Client(panel, "motor", 10, configs.put, parameter_lists.put)
    panel.subscribe("motor/parameter_updates", Message, updates.put)  # is called after the client
    for kind in sorted(publishers, key=first.__ne__):
        with pytest.raises(WaitTimeoutError):
            client.config(0)
        assert configs.empty()
        publishers[kind].publish(messages[kind])
        (updates if kind == "configuration" else parameter_lists).get(timeout=20)
    config = configs.get(timeout=20)
    assert config == client.config(10) and config.groups.groups.Lamp.on is False
    publishers["description"].publish(messages["description"])
    parameter_lists.get(timeout=20)
    publishers["configuration"].publish(encode({**values, "rate": 20.0}))
    assert configs.get(timeout=20)["rate"] == 20.0, "a further description is no further configuration"
    client.close()
