"""dynparam: nodes that are configured while they run (L200); stock: interop/tools/test_tools_more.py."""

from __future__ import annotations

import ast
import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from pyros1.cli.commands.dynparam._files import file_text, read_file_text
from pyros1.cli.running import run_command
from pyros1.finding.packages import PackageIndex
from pyros1.ground.errors import NodeShutdownError, WaitTimeoutError
from pyros1.msgs.dynamic_reconfigure.msg import (
    BoolParameter,
    Config,
    ConfigDescription,
    DoubleParameter,
    Group,
    GroupState,
    IntParameter,
    ParamDescription,
    StrParameter,
)
from pyros1.msgs.dynamic_reconfigure.srv import Reconfigure
from pyros1.node import Node
from pyros1.reconfigure.encoding import decode_configuration
from pyros1.reconfigure.values import ParameterError, convert_value, encode_changes, parse_choices

Run = Callable[..., tuple[int, str, str]]
SIZES = "{'enum': [{'name': 'Small', 'type': 'int', 'value': 0}, {'name': 'Large', 'type': 'int', 'value': 2}]}"


def config(size: int = 0, gain: float = 0.5, text: str = "a", on: bool = True, lights: bool = True) -> Config:
    return Config(
        bools=[BoolParameter("on", on)],
        ints=[IntParameter("size", size)],
        strs=[StrParameter("text", text)],
        doubles=[DoubleParameter("gain", gain)],
        groups=[GroupState("Default", True, 0, 0), GroupState("Lights", lights, 1, 0)],
    )


DESCRIPTION = ConfigDescription(
    groups=[
        Group(
            "Default",
            "",
            [
                ParamDescription("size", "int", 0, "", SIZES),
                ParamDescription("gain", "double", 0, "", ""),
                ParamDescription("text", "str", 0, "", ""),
            ],
            0,
            0,
        ),
        Group("Lights", "", [ParamDescription("on", "bool", 0, "", "")], 0, 1),
    ],
    max=config(2, 1.0),
    min=config(0, 0.0),
    dflt=config(),
)


@pytest.fixture
def run(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, call_main: Any) -> Run:
    for key, value in environ.items():
        monkeypatch.setenv(key, value)
    monkeypatch.delenv("ROS_NAMESPACE", raising=False)
    return partial(call_main, partial(run_command, "dynparam"))


@pytest.fixture
def camera(make_node: Callable[..., Any]) -> list[Config]:
    """A node that can be configured; returns what it was asked for."""
    node = make_node("camera")
    asked: list[Config] = []
    now = {"size": 0, "gain": 0.5, "text": "a", "on": True, "lights": True}

    def change(message: Any) -> Any:
        asked.append(message.config)
        for field in ("bools", "ints", "strs", "doubles"):
            now.update({each.name: each.value for each in getattr(message.config, field)})
        for group in message.config.groups[1:]:
            now["lights"] = group.state
        updates.publish(config(**now))  # type: ignore[arg-type]
        return (config(**now),)  # type: ignore[arg-type]

    node.advertise("~parameter_descriptions", ConfigDescription, latch=True).publish(DESCRIPTION)
    updates = node.advertise("~parameter_updates", Config, latch=True)
    updates.publish(config())
    node.advertise_service("~set_parameters", Reconfigure, change)
    return asked


def values(run: Run) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(run("get", "--json", "/camera")[1])
    return found


def test_nodes_are_listed_and_shown(run: Run, camera: Any) -> None:
    assert run("list") == (0, "/camera\n", "")
    assert run("list", "--json") == (0, '["/camera"]\n', "")
    code, out, err = run("get", "camera")
    assert (code, err) == (0, "") and ast.literal_eval(out) == values(run)
    assert out.startswith("{'on': True, 'size': 0, 'text': 'a', 'gain': 0.5, 'groups': {'id': 0, 'parent': 0, 'name': ")
    assert values(run)["groups"]["groups"]["Lights"]["on"] is True


def test_values_are_set_by_name_as_yaml_and_from_a_file(run: Run, camera: list[Config], tmp_path: Path) -> None:
    assert run("set", "/camera", "size", "large") == (0, "", "")
    assert run("set", "-t", "5", "/camera", "gain", "-1.5") == (0, "", "")
    assert run("set", "/camera", "{text: 5, 'on': false, groups: {Lights: false}}") == (0, "", "")
    assert [each.state for each in camera[-1].groups] == [True, False]
    file = tmp_path / "set.yaml"
    assert run("dump", "/camera", str(file)) == (0, "", "")
    assert file.read_text().startswith("!!python/object/new:dynamic_reconfigure.encoding.Config\ndictitems:\n")
    changed = values(run)
    assert (changed["size"], changed["gain"], changed["text"], changed["on"]) == (2, -1.5, "5", False)
    assert run("set", "/camera", "{size: 0, text: other, groups: {Lights: true}}")[0] == 0
    assert run("load", "/camera", str(file)) == (0, "", "")
    assert values(run) == changed
    file.write_text("gain: 0.25\n---\ntext: plain\n")
    assert run("load", "/camera", str(file)) == (0, "", "")
    assert (values(run)["gain"], values(run)["text"]) == (0.25, "plain")


def test_private_parameters_are_taken(run: Run, camera: Any) -> None:
    assert run("set_from_parameters", "camera", "_gain:=0.75", "_on:=false") == (0, "", "")
    assert (values(run)["gain"], values(run)["on"]) == (0.75, False)
    code, out, err = run("set_from_parameters", "/camera")
    assert (code, out) == (1, "") and "no parameters found on parameter server" in err


def test_launch_files_find_it_without_ros() -> None:
    (path,) = PackageIndex({}, installs=[]).find_executable("dynamic_reconfigure", "dynparam")
    assert "pyros1" in path.read_text()


def test_what_is_wrong_is_said_and_nothing_set(run: Run, camera: list[Config], tmp_path: Path) -> None:
    text = "error updating parameters: don't know parameter: gian\n"
    assert run("set", "/camera", "gian", "1") == (1, text, "pyros1 dynparam: did you mean 'gain'?\n")
    for value in ("big", "1.5", "3000000000"):
        assert run("set", "/camera", "size", value)[:2][1].startswith("error updating parameters: can't set parameter")
    assert "neither true nor false" in run("set", "/camera", "on", "ture")[1]
    assert "don't know group: Light" in run("set", "/camera", "{groups: {Light: true}}")[1]
    assert (
        run("set", "/camera", "[1]")[0] == run("set", "/camera")[0] == run("get")[0] == run("load", "/camera")[0] == 2
    )
    assert "cannot read" in run("load", "/camera", str(tmp_path / "nofile"))[2]
    (tmp_path / "list.yaml").write_text("- 1\n" * 1000)
    code, out, err = run("load", "/camera", str(tmp_path / "list.yaml"))
    assert code == 1 and "expected a dictionary of parameters, not '[1, 1," in out + err and len(out + err) < 400
    assert run()[0] == run("nonsense")[0] == 1
    assert not camera


def test_a_node_that_is_not_there(run: Run, camera: Any) -> None:
    code, out, err = run("get", "-t", "0.1", "/camrea")
    assert (code, out) == (1, "") and "did you mean '/camera'?" in err
    assert run("set", "-t", "0.1", "/nowhere", "a", "1")[:2] == (1, "couldn't set parameters at node /nowhere\n")


def test_ctrl_c_ends_the_waiting_quietly_l04(
    run: Run, camera: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*_: object) -> None:
        raise NodeShutdownError("stopped")

    monkeypatch.setattr(Node, "wait_for_message", stopped)
    for words in (["get", "/camera"], ["set", "/camera", "gain", "1"], ["set_from_parameters", "/camera", "_gain:=1"]):
        assert run(*words) == (0, "", "")
    assert run("dump", "/camera", str(tmp_path / "file")) == (0, "", "") and not (tmp_path / "file").exists()


def test_a_node_that_describes_nothing(run: Run, camera: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def nothing(*_: object) -> None:
        raise WaitTimeoutError("no message came")

    monkeypatch.setattr(Node, "wait_for_message", nothing)
    assert run("dump", "/camera", str(tmp_path / "file"))[:2] == (1, "couldn't get parameters from node /camera\n")
    assert run("get", "/camera")[:2] == (0, "")
    assert run("set", "/camera", "gain", "1")[:2] == (1, "couldn't set parameters at node /camera\n")


def test_without_a_master(run: Run, monkeypatch: pytest.MonkeyPatch, closed_port: int) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", f"http://localhost:{closed_port}")
    code, out, err = run("list")
    assert (code, out) == (1, "") and err.startswith("ERROR: Unable to communicate with master!\n")
    assert run("get", "/x") == (code, out, err)


@pytest.mark.parametrize(
    ("kind", "value", "result"),
    [
        ("int", "12", 12), ("int", True, 1), ("int", 2.75, 2), ("double", "1e3", 1000.0), ("double", 1, 1.0),
        ("str", 5, "5"), ("str", "", ""), ("bool", "ON", True), ("bool", "f", False), ("bool", 0, False),
    ],
)  # fmt: skip
def test_values_become_the_type_of_their_parameter(kind: str, value: Any, result: Any) -> None:
    found = convert_value(value, ParamDescription("p", kind, 0, "", ""))
    assert found == result and type(found) is type(result)


@pytest.mark.parametrize(
    ("kind", "value"),
    [("int", "x"), ("int", None), ("int", float("inf")), ("int", 2**31), ("double", [1]), ("bool", "ja"), ("long", 1)],
)
def test_other_values_are_refused(kind: str, value: Any) -> None:
    with pytest.raises(ParameterError):
        convert_value(value, ParamDescription("p", kind, 0, "", ""))


def test_choices_are_read_and_never_run() -> None:
    assert parse_choices(SIZES) == {"Small": 0, "Large": 2}
    for text in ("", "1", "{'enum': 5}", "__import__('os')", "(" * 10000, "{'enum': [{'name': 'x'}]}"):
        assert parse_choices(text) == {}


def test_files_keep_every_value() -> None:
    odd = config(text="a:\n  dictitems:\n'\u00fc", gain=float("inf"))
    found = decode_configuration(odd, DESCRIPTION)
    assert read_file_text(file_text(found), "file") == found
    assert decode_configuration(Config(), DESCRIPTION) == {} and read_file_text(file_text({}), "file") == {}


def test_the_states_of_groups_come_from_a_dump_too() -> None:
    dumped = decode_configuration(config(lights=False), DESCRIPTION)
    groups = encode_changes({"groups": dumped["groups"]}, DESCRIPTION, config())["groups"]
    assert [(group["name"], group["state"]) for group in groups] == [("Default", True), ("Lights", False)]
    assert encode_changes({"groups": dumped["groups"]}, DESCRIPTION, config(lights=False)) == {}
