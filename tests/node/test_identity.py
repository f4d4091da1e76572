"""identity: a node's name and namespace (N07-N09, N12-N17)."""

from __future__ import annotations

import os
import re
from typing import Any

import pytest

from pyros1.ground.errors import InvalidNameError
from pyros1.node import Node
from pyros1.node.identity import namespace_and_name


@pytest.mark.parametrize(
    ("name", "namespace", "special", "environ", "expected"),
    [
        ("a", None, {}, {}, ("/", "/a")),
        ("a", None, {}, {"ROS_NAMESPACE": "robot"}, ("/robot", "/robot/a")),
        ("a", None, {}, {"ROS_NAMESPACE": "/robot/"}, ("/robot", "/robot/a")),
        ("a", "/mine", {}, {"ROS_NAMESPACE": "/robot"}, ("/mine", "/mine/a")),
        ("a", "/mine", {"__ns": "/theirs/x"}, {"ROS_NAMESPACE": "/robot"}, ("/theirs/x", "/theirs/x/a")),
        ("a", None, {"__name": "b"}, {}, ("/", "/b")),
        ("a", None, {"__name": "", "__ns": ""}, {}, ("/", "/a")),
        ("a", "/", {}, {}, ("/", "/a")),
        ("a", "//x//y/", {}, {}, ("/x/y", "/x/y/a")),
    ],
)
def test_names_n08(name: str, namespace: Any, special: Any, environ: Any, expected: tuple[str, str]) -> None:
    assert namespace_and_name(name, False, namespace, special, environ) == expected


def test_anonymous_names_n09() -> None:
    _, name = namespace_and_name("a", True, None, {}, {})
    assert re.fullmatch(rf"/a_{os.getpid()}_\d{{13}}", name)
    assert namespace_and_name("a", True, None, {"__name": "b"}, {})[1] == "/b", "__name makes it void"


@pytest.mark.parametrize("name", ["", "a/b", "/a", "~a", "1a", "a-b", "ä", "a b", "a\n"])
def test_illegal_names_n07(name: str) -> None:
    with pytest.raises(InvalidNameError, match="not a legal node name"):
        namespace_and_name(name, False, None, {}, {})


@pytest.mark.parametrize("namespace", ["a-b", "~a", "a b", "ä"])
def test_illegal_namespaces(namespace: str) -> None:
    with pytest.raises(InvalidNameError, match="not a legal namespace"):
        namespace_and_name("a", False, namespace, {}, {})


def test_a_node_takes_its_name_from_the_command_line_n14(make_node: Any) -> None:
    node = make_node("a", anonymous=True, argv=["__name:=b", "__ns:=/robot", "x", "t:=u", "--flag", "_p:=1"])
    assert (node.name, node.namespace) == ("/robot/b", "/robot")
    assert node.arguments.rest == ["x", "--flag"], "what rospy's myargv leaves (N15)"
    assert node.resolve("t") == "/robot/u"
    assert node.resolve("~t") == "/robot/b/t"
    assert node.params["~p"] == 1


def test_the_process_arguments_are_the_default_n16(make_node: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", ["program", "__name:=from_argv"])
    assert make_node("a", argv=None).name == "/from_argv"


def test_master_and_host_from_the_command_line_n14(make_node: Any, environ: dict[str, str]) -> None:
    uri = environ.pop("ROS_MASTER_URI")
    node = make_node("a", argv=[f"__master:={uri}", "__hostname:=127.0.0.1"], environ=environ)
    assert node.master_uri == uri
    assert node.uri.startswith("http://127.0.0.1:")


def test_malformed_remappings_are_told_n17(make_node: Any, capsys: Any) -> None:
    make_node("a", argv=["a:=b:=c"])
    assert "invalid remapping argument 'a:=b:=c'" in capsys.readouterr().err


def test_a_node_refuses_a_bad_name_at_once(environ: dict[str, str]) -> None:
    with pytest.raises(InvalidNameError):
        Node("a/b", argv=[], environ=environ)
    with pytest.raises(InvalidNameError):
        Node("a", argv=["x-y:=1", "t:=a-b"], environ=environ)
    with pytest.raises(ValueError, match="callbacks"):
        Node("a", argv=[], environ=environ, callbacks="sometimes")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="loud"):
        Node("a", argv=[], environ=environ, log_level="loud")


def test_warnings_about_the_environment_n22(make_node: Any, environ: dict[str, str], capsys: Any) -> None:
    environ["ROS_IP"] = "http://127.0.0.1"
    make_node("a")
    assert "ROS_IP" in capsys.readouterr().err
