"""bridge param: parameters of another site, through the bridges of both."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from pyros1.bridge.parameters import PARAMETER_SERVICE, decode_parameter_request, encode_json_response, respond
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.service_ends import PARAMETERS_CLASS
from pyros1.cli.running import run_command
from pyros1.ground.errors import ServiceRefusal
from pyros1.msgs import AnyMsg
from pyros1.node import Node

Run = Callable[..., tuple[int, str, str]]
RULES = parse_config("params: [/far]", "f", "red").rules


@pytest.fixture
def run(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, call_main: Any) -> Run:
    for key, value in environ.items():
        monkeypatch.setenv(key, value)
    return partial(call_main, partial(run_command, "bridge"))


def make_bridge(make_node: Callable[..., Node], name: str, site: str) -> Node:
    """Return a node that answers as a bridge does that reaches one site, whose master is the same."""
    node = make_node(name)

    def reply(request: AnyMsg) -> AnyMsg:
        body = bytes(request._buff)
        if decode_parameter_request(body).site != site:
            raise ServiceRefusal(f"there is no site {decode_parameter_request(body).site}")
        return AnyMsg(respond(RULES, node.master, body))

    node.advertise_service("~bridge_status", "std_srvs/Trigger", lambda _: (True, "{}"))
    node.advertise_service(f"~{PARAMETER_SERVICE}", PARAMETERS_CLASS, reply)
    return node


@pytest.fixture
def bridge(make_node: Callable[..., Node]) -> Node:
    """The bridge to site red, beside one to site blue."""
    make_bridge(make_node, "a_bridge", "blue")
    node = make_bridge(make_node, "b_bridge", "red")
    node.master.set_param("/far", {"text": "two\nlines", "speed": 1.0, "\u202e": 5})
    node.master.set_param("/secret", 1)
    return node


def test_names_and_values(run: Run, bridge: Node) -> None:
    code, out, err = run("param", "red:")
    assert (code, err) == (0, "") and out.splitlines() == ["/far/speed", "/far/text", "/far/\\u202e"]
    assert run("param", "red:", "/far/speed") == run("param", "red:/far/speed") == (0, "1.0\n", "")
    assert run("param", "red", "far/text")[1] == "'two\n\n  lines'\n\n"
    assert json.loads(run("param", "red:", "/far", "--json")[1])["speed"] == 1.0
    assert json.loads(run("param", "red:", "--json")[1])[0] == "/far/speed"


def test_a_parameter_is_copied(run: Run, bridge: Node) -> None:
    assert run("param", "red:", "/far/speed", "--to", "/red/speed") == (0, "", "")
    assert bridge.master.get_param("/red/speed") == 1.0


def test_parameters_of_ros2(run: Run, make_node: Callable[..., Node], bridge: Node) -> None:
    values = {"gains.p": 1.5, "big": 1 << 40, "text": "a\x01", "flags": [True]}
    asked = []

    def reply(request: AnyMsg) -> AnyMsg:
        asked.append(decode_parameter_request(bytes(request._buff)))
        return AnyMsg(encode_json_response(values if asked[-1].name == "/n" else values["gains.p"]))

    node = make_node("c_bridge")
    node.advertise_service("~bridge_status", "std_srvs/Trigger", lambda _: (True, "{}"))
    node.advertise_service(f"~{PARAMETER_SERVICE}", PARAMETERS_CLASS, reply)
    assert run("param", "ros2:", "/n/gains.p") == (0, "1.5\n", "")
    assert run("param", "ros2:/n/qos_overrides./tf.depth")[0] == 0
    assert [*asked] == [("ros2", "/n/gains.p"), ("ros2", "/n/qos_overrides./tf.depth")]
    assert json.loads(run("param", "ros2:", "/n", "--json")[1]) == values
    code, _, err = run("param", "ros2:", "/n", "--to", "/copy")
    assert code == 1 and "the integer 1099511627776 does not fit" in err
    assert run("param", "ros2:/n/gains.p", "--to", "/copy") == (0, "", "")
    assert bridge.master.get_param("/copy") == 1.5


@pytest.mark.parametrize(
    ("words", "code", "complaint"),
    [
        (["red:", "/secret"], 1, "ERROR: site red has no parameter /secret that others may read"),
        (["green:", "/far"], 1, "ERROR: there is no site green"),
        (["r-d:", "/far"], 2, "ERROR: 'r-d' cannot be a site's name"),
        (["red:", "/a b"], 2, "ERROR: '/a b' is not the full name of a parameter"),
        (["red:", "/a.b"], 2, "ERROR: '/a.b' is not the full name of a parameter"),
        (["ros2:", "/a\tb"], 2, "ERROR: '/a\\tb' is not the full name of a parameter"),
        (["ros2:", "/a"], 1, "ERROR: there is no site ros2"),
        (["red:", "--to", "/x"], 2, "--to needs a parameter of the other site"),
        (["red:/far", "/x"], 2, "too many arguments"),
        ([], 2, "name a site, such as red:, and a parameter"),
    ],
)
def test_mistakes(run: Run, bridge: Node, words: list[str], code: int, complaint: str) -> None:
    found, out, err = run("param", *words)
    assert (found, out) == (code, "") and complaint in err and "Traceback" not in err


def test_without_a_bridge(run: Run, make_node: Callable[..., Node]) -> None:
    make_node("user")
    code, _, err = run("param", "red:")
    assert code == 1 and err.startswith("ERROR: no bridge is running on this master; start one with: pyros1 bridge")
    make_node("old").advertise_service("~bridge_status", "std_srvs/Trigger", lambda _: (True, "{}"))
    code, _, err = run("param", "red:")
    assert code == 1 and "no node provides it" in err
