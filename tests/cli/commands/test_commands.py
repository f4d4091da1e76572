"""The commands against a master and a node of our own, in this process."""

from __future__ import annotations

import json
import math
import os
import queue
import re
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from pyros1.cli import registry
from pyros1.cli.main import entry
from pyros1.msgs import load_message, load_service
from pyros1.msgs.sensor_msgs.msg import JointState
from pyros1.msgs.std_msgs.msg import Bool, Empty, Float64, String
from pyros1.msgs.std_srvs.srv import SetBool, SetBoolResponse
from pyros1.observe.fields import expand_fields


@pytest.fixture
def run(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, call_main: Any) -> Any:
    for key, value in environ.items():
        monkeypatch.setenv(key, value)
    monkeypatch.delenv("ROS_NAMESPACE", raising=False)
    return partial(call_main, entry, "pyros1")


def test_every_command_has_a_module_and_a_stock_name() -> None:
    known = registry.commands()
    assert {registry.command_name("ros" + name) for name in known} == set(known) - {"console"}
    assert registry.command_name("rosconsole") == "log", "as stock's"
    assert registry.command_name("console") == "console"
    assert registry.command_name("rosrosy") is None and registry.command_name("topics") is None


def test_help_version_and_unknown_command(run: Any) -> None:
    assert run("--version")[0] == 0 and run("help")[0] == 0
    assert run("nonsense")[0] == 64
    assert run()[0] == 64
    assert run("topic")[0] == 64 and run("param")[0] == 0  # L02


def test_topics_and_nodes_are_listed(run: Any, make_node: Callable[..., Any]) -> None:
    """L25, L26, L28, L29, L70, L72"""
    node = make_node("talker", rosout=False)
    node.advertise("t", String)
    assert run("topic", "list") == (0, "/t\n", "")
    assert run("rostopic", "list") == (0, "/t\n", "")
    assert run("topic", "list", "-v")[1] == (
        "\nPublished topics:\n * /t [std_msgs/String] 1 publisher\n\nSubscribed topics:\n\n"
    )
    assert run("topic", "type", "t") == (0, "std_msgs/String\n", "")
    assert run("topic", "info", "/nope") == (1, "", "ERROR: Unknown topic /nope\n")
    assert run("topic", "info", "t")[1] == (
        f"Type: std_msgs/String\n\nPublishers: \n * /talker ({node.uri})\n\nSubscribers: None\n\n\n"
    )
    assert run("node", "list") == (0, "/talker\n", "")
    code, out, err = run("node", "info", "/nope")
    assert code == 0 and "Publications: None" in out and err == "cannot contact [/nope]: unknown node\n"


def test_echo_shows_a_message_and_its_fields(run: Any, make_node: Callable[..., Any]) -> None:
    """L60-L62"""
    node = make_node("talker", rosout=False)
    node.advertise("t", Float64, latch=True).publish(2.5)
    assert run("topic", "echo", "-n", "1", "/t") == (0, "data: 2.5\n---\n", "")
    assert run("topic", "echo", "-n", "1", "/t/data") == (0, "2.5\n---\n", "")
    out = run("topic", "echo", "-n", "1", "-p", "/t")[1].splitlines()
    assert out[0] == "%time,field.data" and out[1].endswith(",2.5")


def test_parameters(run: Any) -> None:
    """L80, L81, L83, L85"""
    assert run("param", "set", "/a", "{x: 1, y: {z: [1]}}") == (0, "", "")
    assert run("param", "get", "/a") == (0, "x: 1\ny:\n  z:\n  - 1\n\n", "")
    assert run("param", "set", "/a/x", "-7") == (0, "", "")
    assert run("param", "list", "/a") == (0, "/a/x\n/a/y/z\n", "")
    assert run("param", "get", "/a/x") == (0, "-7\n", "")
    assert run("param", "get", "/nope") == (1, "", "ERROR: Parameter [/nope] is not set\n")
    for words in (["-"], ["--", "-"], ["--", "--"]):
        code, out, err = run("param", "set", "/dash", *words)
        assert (code, out) == (2, "") and err.endswith("error: invalid arguments. Please specify a parameter value\n")
    code, out, err = run("param", "set", "/big", "5000000000")
    assert (code, out) == (1, "") and err.startswith("ERROR: ")


def test_empty_dictionaries_are_kept(run: Any, tmp_path: Path) -> None:
    file = tmp_path / "in.yaml"
    file.write_text("a: {}\nb: {c: {}, d: 1}\n")
    assert run("param", "load", str(file), "/n") == (0, "", "")
    assert run("param", "get", "/n") == (0, "a: {}\nb:\n  c: {}\n  d: 1\n\n", "")
    assert run("param", "set", "/n/a/x", "5") == (0, "", "")
    assert run("param", "load", str(file), "/n") == (0, "", "")  # what is in a namespace stays
    assert run("param", "get", "/n/a") == (0, "x: 5\n\n", "")
    assert run("param", "set", "/n/b/d", "{}") == (0, "", "")
    assert run("param", "get", "/n/b/d") == (0, "{}\n\n", "")
    assert run("param", "set", "/", "{}") == (0, "", "")
    assert run("param", "list", "/n") == (0, "/n/a/x\n", "")


def test_services(run: Any, make_node: Callable[..., Any]) -> None:
    """L76-L78"""
    node = make_node("server", rosout=False)
    node.advertise_service("~flip", SetBool, lambda request: SetBoolResponse(request.data, "ok"))
    levels = "/server/get_loggers\n/server/set_logger_level\n"
    assert run("service", "list") == (0, f"/server/flip\n{levels}", "")
    assert run("service", "type", "/server/flip") == (0, "std_srvs/SetBool\n", "")
    assert run("service", "call", "/server/flip", "true") == (0, 'success: True\nmessage: "ok"\n', "")
    assert run("service", "call", "/nope", "1") == (2, "", "ERROR: Service [/nope] is not available.\n")


def test_arguments_of_a_service_are_those_that_call_takes(run: Any, make_node: Callable[..., Any]) -> None:
    plans = load_service("nav_msgs/GetPlan")
    make_node("server", rosout=False).advertise_service("plan", plans, lambda request: plans._response_class())
    assert run("service", "args", "/plan") == (0, "start goal tolerance\n", "")
    assert run("service", "info", "/plan")[1].endswith("\nType: nav_msgs/GetPlan\nArgs: start goal tolerance\n")
    assert json.loads(run("service", "info", "--json", "/plan")[1])["args"] == ["start", "goal", "tolerance"]
    assert run("service", "call", "/plan", "{}", "{}", "0.5")[0] == 0


def test_an_unreachable_master_is_said_in_the_stock_words(run: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """L03"""
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:9/")
    text = (
        "ERROR: Unable to communicate with master!\n"
        "no answer from the master at http://localhost:9/ (cannot reach http://localhost:9/: Connection refused).\n"
        "Is it running? Start one with: pyros1 core. Is it elsewhere? Set ROS_MASTER_URI.\n"
    )
    assert run("topic", "list") == (1, "", text)
    assert run("service", "list") == (2, "", text)
    assert run("topic", "echo", "/x") == (1, "", text)


def test_words_that_look_like_options_and_remappings_get_a_hint(run: Any) -> None:
    code, _, err = run("topic", "echo", "/x", "_rate=5")
    assert code == 2 and err.endswith("\n'_rate=5' is neither a remapping nor a parameter: write _rate:=5\n")
    code, _, err = run("topic", "pub", "\u2013r", "10", "/x", "std_msgs/String", "a=b")
    assert code == 1 and err.endswith("begins with a typographic dash, not with '-': write -r\n")
    assert "a:=b" not in err, "it is a message"
    assert "write" not in run("service", "call", "/nope", "a: 5")[2]
    code, _, err = run("bridge", "keys", "keys", "ca", "base=base.example")
    assert code == 1 and "write" not in err, "it is a site with its host name"


@pytest.mark.parametrize("uri", ["localhost:11311", "http://127.0.0.1:99999", "https://localhost:11311"])
def test_a_ros_master_uri_that_is_none_is_said_to_be_that(run: Any, monkeypatch: pytest.MonkeyPatch, uri: str) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", uri)
    code, _, err = run("topic", "list")
    assert code == 1 and repr(uri) in err
    assert (
        "Is ROS_MASTER_URI correct? For a master on this machine: export ROS_MASTER_URI=http://localhost:11311" in err
    )


def test_an_unknown_host_in_ros_master_uri_is_said_to_be_that(run: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", "http://nowhere.invalid:11311")
    code, out, err = run("topic", "list")
    assert (code, out) == (1, "") and err.startswith("ERROR: Unable to communicate with master!\n")
    assert "http://nowhere.invalid:11311 (the host name 'nowhere.invalid' cannot be resolved here" in err
    assert "add a line 'ADDRESS nowhere.invalid' to /etc/hosts" in err


def test_listing_topics_imports_nothing_heavy(environ: dict[str, str]) -> None:
    code = (
        "import sys; from pyros1.cli.main import entry; entry(['pyros1', 'topic', 'list']);"
        "print(','.join(m for m in sys.modules), file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], env={**environ, "PYTHONPATH": ":".join(sys.path)}, capture_output=True, check=True
    )
    loaded = set(done.stderr.decode().strip().split(","))
    heavy = {
        "pyros1.node",
        "pyros1.msgs.base",
        "pyros1.values",
        "yaml",
        "logging",
        "argparse",
        "http.client",
        "xmlrpc.client",
    }
    assert not loaded & heavy


def test_listings_as_json(run: Any, make_node: Callable[..., Any]) -> None:
    node = make_node("talker", rosout=False)
    node.advertise("ns/t", String)
    entry = {"topic": "/ns/t", "type": "std_msgs/String", "publishers": ["/talker"], "subscribers": []}
    assert json.loads(run("topic", "list", "--json")[1]) == [entry]
    assert json.loads(run("topic", "list", "--json", "-s")[1]) == []
    publishers = [{"node": "/talker", "uri": node.uri}]
    assert json.loads(run("topic", "info", "--json", "/ns/t")[1]) == {**entry, "publishers": publishers}
    assert json.loads(run("topic", "find", "--json", "std_msgs/String")[1]) == [
        {"topic": "/ns/t", "type": "std_msgs/String"}
    ]


def test_services_and_parameters_as_json(run: Any, make_node: Callable[..., Any]) -> None:
    node = make_node("flipper", rosout=False)
    node.advertise_service("flip", SetBool, lambda request: SetBoolResponse(True, "it's " + str(request.data)))
    assert {"service": "/flip", "nodes": ["/flipper"]} in json.loads(run("service", "list", "--json")[1])
    shown = json.loads(run("service", "info", "--json", "flip")[1])
    assert shown.pop("uri") == run("service", "uri", "flip")[1].strip()
    assert shown == {"service": "/flip", "node": "/flipper", "type": "std_srvs/SetBool", "args": ["data"]}
    assert json.loads(run("service", "find", "--json", "std_srvs/SetBool")[1]) == ["/flip"]
    answer = {"success": True, "message": "it's False"}
    assert json.loads(run("service", "call", "--json", "flip", "false")[1]) == answer
    assert run("service", "call", "--nostr", "flip", "false")[1] == 'success: True\nmessage: "<string length: 10>"\n'
    assert "did you mean '/flip'?" in run("service", "call", "/filp", "true")[2]
    run("param", "set", "/gains", "{p: 1.5, i: [1, 2]}")
    assert json.loads(run("param", "get", "--json", "/gains")[1]) == {"p": 1.5, "i": [1, 2]}
    assert "/gains/p" in json.loads(run("param", "list", "--json")[1])
    assert "did you mean '/gains/p'?" in run("param", "get", "/gain/p")[2]


def test_nodes_as_json_and_as_a_tree(run: Any, make_node: Callable[..., Any]) -> None:
    talker, listener = make_node("talker", namespace="ns", rosout=False), make_node("listener", rosout=False)
    talker.advertise("t", String)
    listener.subscribe("/ns/t", String, lambda message: None)
    talker.advertise_service("flip", SetBool, lambda request: SetBoolResponse())
    assert json.loads(run("node", "list", "--json")[1]) == [
        {"node": "/listener", "uri": listener.uri},
        {"node": "/ns/talker", "uri": talker.uri},
    ]
    facts = json.loads(run("node", "info", "--json", "/ns/talker")[1])[0]
    assert facts["pid"] == os.getpid() and facts["publishes"] == ["/ns/t"] and facts["uri"] == talker.uri
    assert run("node", "tree")[1].split("\n") == [
        "/",
        "├─ listener",
        "│    <─ /ns/t [std_msgs/String] /ns/talker",
        "└─ ns/",
        "   └─ talker",
        "        ─> /ns/t [std_msgs/String] /listener",
        "        () /ns/flip",
        "",
    ]
    assert json.loads(run("node", "tree", "--json", "/ns")[1])[0]["services"] == ["/ns/flip"]
    assert "did you mean '/listener'?" in run("node", "info", "listenr")[2]


def test_topics_are_found_by_what_they_are_like(run: Any, make_node: Callable[..., Any]) -> None:
    node = make_node("talker", rosout=False)
    for topic, kind in (("front/scan", String), ("cmd_vel", Float64), ("status", String)):
        node.advertise(topic, kind)
    assert run("topic", "find", "--like", "SCAN") == (0, "/front/scan\n", "")
    assert run("topic", "find", "--like", "cmd_val") == (0, "/cmd_vel\n", "")
    assert run("topic", "find", "--like", "float") == (0, "/cmd_vel\n", "")
    assert run("topic", "find", "--like", "string")[1].split() == ["/front/scan", "/status"]


def test_misspelt_verbs_and_topics_get_a_hint(run: Any, make_node: Callable[..., Any]) -> None:
    make_node("talker", rosout=False).advertise("velocity", Float64)
    code, out, err = run("topic", "ecoh")
    assert code == 64 and out.startswith("pyros1 topic is a command-line tool") and "did you mean 'echo'?" in err
    assert run("topic", "info", "/velocitty")[2] == "ERROR: Unknown topic /velocitty (did you mean '/velocity'?)\n"
    assert "did you mean '/velocity'?" in run("topic", "type", "/velocty")[2]


@pytest.mark.slow
def test_echo_writes_json_that_pub_reads(
    run: Any, make_node: Callable[..., Any], tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.cli.commands.topic.pub.HOLD_SECONDS", 2.0)
    state = JointState(name=["a"], position=[1.5, math.inf])
    talker = make_node("talker", rosout=False)
    talker.advertise("state", JointState, latch=True).publish(state)
    code, out, err = run("topic", "echo", "--json", "-n", "1", "/state")
    assert (code, err) == (0, "") and json.loads(out)["position"] == [1.5, "Infinity"]
    got: queue.Queue[Any] = queue.Queue()
    talker.subscribe("copy", JointState, got.put)
    (tmp_path / "state.jsonl").write_text(out)
    assert run("topic", "pub", "-1", "-f", str(tmp_path / "state.jsonl"), "/copy", "sensor_msgs/JointState")[0] == 0
    copy = got.get(timeout=10)
    assert copy.name == ["a"] and list(copy.position) == [1.5, math.inf]
    assert json.loads(run("topic", "echo", "--json", "--noarr", "-n", "1", "/state")[1]).keys() == {"header"}
    assert json.loads(run("topic", "echo", "--json", "-n", "1", "/state/position[0]")[1]) == 1.5


def test_pub_takes_the_lines_of_its_topic_from_an_export(run: Any, make_node: Any, tmp_path: Any) -> None:
    words = [("/said", "one"), ("/other", "two"), ("/said", "three")]
    lines = [{"topic": topic, "type": "std_msgs/String", "time": 1.0, "message": {"data": it}} for topic, it in words]
    file = tmp_path / "export.jsonl"
    file.write_text("".join(json.dumps(line) + "\n" for line in lines))
    got: queue.Queue[Any] = queue.Queue()
    make_node("listener", rosout=False).subscribe("said", "std_msgs/String", got.put)
    code, out, _ = run("topic", "pub", "-v", "-r", "50", "-f", str(file), "/said", "std_msgs/String")
    assert (code, out) == (
        0,
        "".join(f'publishing and latching [data: "{it}"] for 3.0 seconds\n' for it in ("one", "three")),
    )
    assert [got.get(timeout=10).data for _ in range(2)] == ["one", "three"]
    code, _, error = run("topic", "pub", "-f", str(file), "/nobody", "std_msgs/String")
    assert code != 0 and "no line contains a message of /nobody, only of: /other, /said" in error


def test_listings_are_lists_in_json(run: Any, make_node: Callable[..., Any], tmp_path: Any) -> None:
    make_node("talker", rosout=False)
    assert json.loads(run("node", "machine", "--json")[1]) == ["localhost"]
    assert json.loads(run("node", "machine", "localhost", "--json")[1]) == ["/talker"]
    file = tmp_path / "x.launch"
    file.write_text('<launch><node pkg="p" type="t" name="n"/></launch>')
    assert json.loads(run("launch", "--nodes", str(file), "--json")[1]) == ["/n"]
    assert json.loads(run("launch", "--files", str(file), "--json")[1]) == [str(file)]


def test_misspelt_commands_and_types_get_a_hint(run: Any) -> None:
    code, _, error = run("tpoic")
    assert code == 64 and "did you mean 'topic'?" in error
    assert "(did you mean 'std_msgs/Float64'?)" in run("msg", "show", "std_msgs/Floa64")[2]


@pytest.mark.slow
def test_minus_one_is_an_option_or_a_number(
    run: Any, make_node: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.cli.commands.topic.pub.HOLD_SECONDS", 2.0)
    got: queue.Queue[Any] = queue.Queue()
    listener = make_node("listener", rosout=False)
    listener.subscribe("text", "std_msgs/String", got.put)
    listener.subscribe("place", "geometry_msgs/Point", got.put)
    assert run("topic", "pub", "/text", "std_msgs/String", "hello", "-1")[0] == 0
    assert run("topic", "pub", "-1", "/place", "geometry_msgs/Point", "1", "2", "-1")[0] == 0
    assert got.get(timeout=10).data == "hello"
    assert got.get(timeout=10).z == -1.0


def test_rows_for_spreadsheets(run: Any, make_node: Callable[..., Any]) -> None:
    """As stock: truth is 1 or 0, raw data is left out, and a message without fields has an empty column."""
    talker = make_node("talker", rosout=False)
    image: Any = load_message("sensor_msgs/Image")()
    image.data = b"abc"
    talker.advertise("image", "sensor_msgs/Image", latch=True).publish(image)
    talker.advertise("flag", "std_msgs/Bool", latch=True).publish(Bool(True))
    talker.advertise("nothing", "std_msgs/Empty", latch=True).publish(Empty())
    names, values = run("topic", "echo", "-p", "-n", "1", "/image")[1].splitlines()
    assert (names.split(",")[-1], len(values.split(","))) == ("field.step", len(names.split(",")))
    assert run("topic", "echo", "-p", "-n", "1", "/image/data")[1].splitlines()[1].endswith(",97,98,99")
    assert run("topic", "echo", "-p", "-n", "1", "/flag")[1].endswith(",1\n")
    assert re.fullmatch(r"%time,\n\d+,\n", run("topic", "echo", "-p", "-n", "1", "/nothing")[1])
    code, _, error = run("topic", "echo", "-w", "1", "/image")
    assert (code, "must be at least 2" in error) == (2, True)


def test_files_that_do_not_do(run: Any, tmp_path: Any) -> None:
    assert run("param", "dump", str(tmp_path / "nope" / "x.yaml"))[::2] == (
        1,
        f"ERROR: {tmp_path}/nope/x.yaml: No such file or directory\n",
    )
    (tmp_path / "raw").write_bytes(b"a: \xff")
    code, _, error = run("param", "load", str(tmp_path / "raw"))
    assert (code, error) == (1, "ERROR: the input is not UTF-8 text: byte 0xff at offset 3\n")


def test_memory_that_ends_is_said(run: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def greedy(*_: Any) -> int:
        raise MemoryError

    monkeypatch.setattr("pyros1.cli.commands.version.COMMAND.verb.run", greedy)
    assert run("version") == (1, "", "ERROR: not enough memory\n")


def test_closed_streams_are_no_error(environ: dict[str, str]) -> None:
    words = [sys.executable, "-m", "pyros1", "topic", "list"]
    done = subprocess.run(["sh", "-c", '"$@" >&-', "sh", *words], env={**os.environ, **environ}, check=False)
    assert done.returncode == 0


def test_plot_draws_what_comes(run: Any, make_node: Callable[..., Any]) -> None:
    node = make_node("talker", rosout=False)
    publisher = node.advertise("state", JointState, latch=True)
    publisher.publish(JointState(position=[3.0, 4.0]))
    code, out, err = run("topic", "plot", "-p", "0.3", "--once", "/state/header")
    assert (code, err) == (0, "") and "/state/header/seq = " in out  # of a message, its numbers
    code, out, err = run("topic", "plot", "-p", "0.3", "--once", "/state/position[0],/state/position[1]")
    assert (code, err) == (0, "")
    assert "/state/position[0] = 3" in out and "/state/position[1] = 4" in out
    code, out, err = run("topic", "plot", "-p", "0.3", "--once", "/state: m.position[0] * 4")
    assert (code, err) == (0, "") and "/state: m.position[0] * 4 = " in out
    assert "never" in run("topic", "plot", "/state: never(m.position)")[2]
    assert "/state is not a number" in run("topic", "plot", "-p", "5", "--once", "/state")[2]
    assert "has no field 'nope'" in run("topic", "plot", "-p", "5", "--once", "/state/nope")[2]
    assert expand_fields("/imu/a/x:y:z,/b") == ["/imu/a/x", "/imu/a/y", "/imu/a/z", "/b"]


def test_help_has_examples_but_under_stock_names(run: Any) -> None:
    assert "Examples:\n  pyros1 topic echo /pose" in run("topic", "echo", "-h")[1]


@pytest.mark.parametrize("word", ["help", "-h", "--help"])
def test_help_of_one_verb(run: Any, word: str) -> None:
    assert run("bag", word, "info") == run("bag", "info", "-h")
    assert run("topic", word, "echo") == run("topic", "echo", "-h")
    assert run("bag", word, "none") == run("bag", word)


def test_help_of_a_command(run: Any) -> None:
    assert run("help", "bag") == run("bag", "-h")
    assert run("help", "topic", "echo") == run("topic", "echo", "-h")
    assert run("help", "topc") == (64, "", "pyros1: unknown command 'topc' (did you mean 'topic'?); see: pyros1 help\n")
    assert "(also: doctor)" in run("help")[1]


def test_a_check_of_one_file(run: Any, tmp_path: Path) -> None:
    (tmp_path / "x.launch").write_text("<launch/>")
    assert run("launch", "--check", str(tmp_path / "x.launch"))[1] == "no problems: 1 file, 0 nodes, 0 parameters\n"


VERBS = ["topic", "node", "service", "param", "msg", "srv", "log", "tf", "dynparam", "bag", "topic_tools"]


@pytest.mark.parametrize("command", registry.commands())
@pytest.mark.parametrize("word", ["-h", "--help"])
def test_every_command_explains_itself(run: Any, command: str, word: str) -> None:
    code, out, err = run(command, word)
    assert (code, err) == (0, "") and ("sage" in out or "ommands" in out)


def test_stock_list_leaves_out_what_has_no_text_there(run: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "\tpyros1 service node\t" in run("service", "-h")[1]
    monkeypatch.setattr("sys.argv", ["rosservice"])
    assert "\trosservice call\t" in run("service")[1] and "service node" not in run("service")[1]


@pytest.mark.parametrize("command", VERBS)
def test_what_is_no_verb_is_said_to_be_none(run: Any, command: str) -> None:
    code, _, err = run(command, "bogus")
    assert code != 0 and err == f"pyros1 {command}: unknown command 'bogus'\n"


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        ("topic relay /a /b", "'relay' (did you mean 'pyros1 topic_tools relay'?)"),
        ("hz /a", "'hz' (did you mean 'pyros1 topic hz'?)"),
        ("topic ls", "'ls' (did you mean 'list'?)"),
        ("setup fish", "unrecognized arguments: fish (write --shell fish)"),
        ("topic pub /x String 1", "invalid topic type: String (did you mean 'std_msgs/String'?)"),
        ("topic pub /x std_msgs/Strng 1", "invalid message type: std_msgs/Strng (did you mean 'std_msgs/String'?)."),
        ("node kill /a/tool", " * /a/tool (did you mean '/a/tools'?)"),
        ("tf ecko", "pyros1 tf: unknown command 'ecko' (did you mean 'echo'?)"),
    ],
)
def test_hints_at_what_was_meant(
    call_main: Any, make_node: Any, environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, words: str, hint: str
) -> None:
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    make_node("tools", namespace="/a") if "kill" in words else None
    _, out, err = call_main(entry, "pyros1", *words.split())
    assert (out + err).count(hint) == 1
