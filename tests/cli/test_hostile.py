"""What others send reaches no terminal as it is: every command, shown a robot whose every text would steer it.

Feature: text from other nodes cannot control the terminal -- escape sequences and line breaks in names, text and
    errors are shown escaped
"""

from __future__ import annotations

import io
import json
import queue
import socket
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from pyros1.bag import Bag, BagWriter
from pyros1.cli.clean_output import CleanStream
from pyros1.cli.commands.diagnostic import status_lines
from pyros1.cli.commands.tf._drawing import Frame, format_tree
from pyros1.cli.invocation import Invocation
from pyros1.cli.main import entry
from pyros1.ground.errors import ServiceError
from pyros1.msgs import load_message
from pyros1.node.log.sink import LogSink, Record
from pyros1.tf import Buffer
from pyros1.wire.header import encode_header

from ..bodies import encode
from ..parts import tcpros_port
from .hostile import BAD, WORSE, HostileRobot, assert_clean

COMMANDS = [
    "topic list",
    "topic list -v",
    "topic list --json",
    "topic info /topic",
    "topic info /topicBAD",
    "topic type /topic",
    "topic type /topicBAD",
    "topic find std_msgs/String",
    "topic find std_msgs/BadBAD",
    "topic echo -n 1 /topic",
    "topic echo -n 1 /topic/data",
    "topic echo -n 1 -p /topic",
    "topic echo -n 1 --json /topic",
    "topic echo -n 1 /topicBAD",
    "topic info --json /topic",
    "log set /node rosout info",
    "node list",
    "node list -a",
    "node list -u",
    "node list --json",
    "node list --check",
    "node info /node",
    "node info /nodeBAD",
    "node info --json /node",
    "node ping -c 1 /node",
    "node ping -c 1 /nodeBAD",
    "node ping -a",
    "node machine",
    "node tree",
    "node kill /nodeBAD",
    "service list",
    "service list -n",
    "service list --json",
    "service info /service",
    "service info /serviceBAD",
    "service type /service",
    "service uri /serviceBAD",
    "service node /service",
    "service args /service",
    "service find std_srvs/Trigger",
    "service call /service",
    "param list",
    "param get /p",
    "param get /q",
    "param get -p /q",
    "param get /pBAD",
    "param dump",
    "param delete /pBAD",
    "graph --once",
    "graph --dot",
    "graph --json",
    "log list",
    "log list /node",
    "log get /node rosout",
    "dynparam list",
    "version",
    "wtf",
]


@pytest.fixture
def make_robot() -> Iterator[Callable[[str], HostileRobot]]:
    """Return a function that makes hostile robots."""
    robots: list[HostileRobot] = []

    def make(mode: str) -> HostileRobot:
        robots.append(HostileRobot(mode))
        return robots[-1]

    yield make
    for robot in robots:
        robot.close()


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, call_main: Any, tmp_path: Path) -> Callable[..., tuple[int, str, str]]:
    """Return a function that runs a command on a robot."""
    monkeypatch.setenv("ROS_HOSTNAME", "localhost")
    monkeypatch.setenv("ROS_HOME", str(tmp_path))

    def run(uri: str, command: str) -> tuple[int, str, str]:
        monkeypatch.setenv("ROS_MASTER_URI", uri)
        words = [word.replace("BAD", BAD) for word in command.split(" ")]
        code, out, err = call_main(entry, "pyros1", *words)
        assert_clean(out, command)
        assert_clean(err, command)
        assert "Traceback" not in err, command
        return code, out, err

    return run


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["answer", "fail", "wrong", "fault", "refuse"])
def test_no_command_shows_what_steers_a_terminal(run: Any, make_robot: Any, mode: str) -> None:
    robot, seen = make_robot(mode), 0
    for command in COMMANDS:
        if mode == "refuse" and "echo" in command:
            continue  # waits for a publisher that takes it
        _, out, err = run(robot.uri, command)
        seen += "FORGED" in out + err
    assert seen > len(COMMANDS) // 2, "the texts are shown, but cleaned"


@pytest.mark.parametrize("how", ["", "-p ", "--json "])
def test_message_data_does_not_steer_a_terminal_either(
    run: Any, make_robot: Any, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    """On a terminal the colours of a command itself pass: data must have lost its own before."""
    monkeypatch.setattr(CleanStream, "__init__", _as_on_a_terminal)
    monkeypatch.setenv("NO_COLOR", "1")
    robot = make_robot("answer")
    assert "FORGED" in run(robot.uri, f"topic echo -n 1 {how}/topic")[1]
    assert "FORGED" in run(robot.uri, f"topic echo -n 1 {how}/topic/data")[1]


@pytest.mark.parametrize("command", ["topic hz /topic", "topic bw /topic", "topic delay /topic"])
def test_nor_do_those_that_run_until_they_are_interrupted(
    run: Any, make_robot: Any, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    rounds = iter([True, True])

    def pause(self: Invocation, seconds: float) -> bool:
        return not self._wait_for_shutdown(0.1) and next(rounds, False)

    monkeypatch.setattr(Invocation, "pause", pause)
    assert "".join(run(make_robot("answer").uri, command)[1:])


def test_nor_do_parameters_that_are_asked_for_within_a_time(run: Any, make_robot: Any) -> None:
    robot = make_robot("answer")
    assert any("".join(run(robot.uri, f"dynparam get -t {timeout} /node")[1:]) for timeout in (0.1, 1, 10))


def test_nor_does_recording_and_an_illegal_name_ends_it_not(run: Any, make_robot: Any, tmp_path: Path) -> None:
    path = tmp_path / "all.bag"
    code, out, err = run(make_robot("answer").uri, f"bag record -a --duration 1 -O {path}")
    assert code == 0 and "Subscribing to /topic\n" in out and "is not a legal name and is not recorded" in out + err
    with Bag(path) as bag:
        assert len(bag) >= 1


def _as_on_a_terminal(self: CleanStream, stream: Any) -> None:
    self.underlying, self._keeps_escape_sequences = stream, True


def test_json_keeps_what_others_sent(run: Any, make_robot: Any) -> None:
    robot = make_robot("answer")
    assert json.loads(run(robot.uri, "topic list --json")[1])[1]["topic"] == "/topic" + BAD
    assert json.loads(run(robot.uri, "topic echo -n 1 --json /topic")[1])["data"] == "data" + WORSE
    assert "/node" + BAD in json.loads(run(robot.uri, "graph --json")[1])["nodes"]


def test_a_node_shows_nothing_of_the_kind(
    make_robot: Any, make_node: Any, logged: queue.Queue[str], environ: dict[str, str], capfd: Any
) -> None:
    environ["ROS_MASTER_URI"] = make_robot("refuse").uri
    node = make_node("victim")
    node.subscribe("/topic", "std_msgs/String", print)
    while "refused the connection" not in logged.get(timeout=10):
        pass
    for broken in (node.service("/service", "std_srvs/Trigger"), lambda: node.params["/p" + BAD]):
        try:
            value = broken()
        except Exception as error:  # noqa: BLE001 - whatever the program would be shown
            assert_clean(str(error))
        else:
            assert value
    with socket.create_connection(("localhost", tcpros_port(node))) as peer:
        peer.sendall(encode_header({"topic": "/t" + WORSE, "callerid": "/peer" + WORSE, "md5sum": "*"}))
        while "refused a connection from /peer" not in logged.get(timeout=10):
            pass
    node.shutdown()
    out, err = capfd.readouterr()
    assert "FORGED" in err
    assert_clean(out)
    assert_clean(err)
    for file in Path(environ["ROS_HOME"]).rglob("*.log"):
        assert_clean(file.read_text(encoding="utf-8"))


def test_what_a_service_answers_is_shown_clean(make_robot: Any, make_node: Any, environ: dict[str, str]) -> None:
    environ["ROS_MASTER_URI"] = make_robot("answer").uri
    node = make_node("victim")
    with pytest.raises(ServiceError, match="responded with an error: failed") as raised:
        node.service("/service", "std_srvs/Trigger")()
    assert_clean(str(raised.value))


@pytest.fixture
def logged(monkeypatch: pytest.MonkeyPatch) -> queue.Queue[str]:
    """What nodes of this process log from now on."""
    lines: queue.Queue[str] = queue.Queue()
    emit = LogSink.emit

    def emit_and_keep(sink: LogSink, record: Record, *words: Any, **options: Any) -> None:
        emit(sink, record, *words, **options)
        lines.put(record.text)

    monkeypatch.setattr(LogSink, "emit", emit_and_keep)
    return lines


def test_log_messages_of_others(run: Any, make_node: Any, environ: dict[str, str]) -> None:
    from pyros1.msgs.rosgraph_msgs.msg import Log

    publisher = make_node("talker", rosout=False).advertise("/hostile_log", Log, latch=True)
    publisher.publish(Log(level=8, name="/n" + WORSE, msg="text" + WORSE, file=WORSE, function=WORSE))
    out = run(environ["ROS_MASTER_URI"], "log echo --once --verbose --topic /hostile_log")[1]
    assert out.startswith("[ ERROR ] [/n") and "FORGED" in out
    node = make_node("named")
    node.log.named("logger" + WORSE)
    assert "FORGED" in run(environ["ROS_MASTER_URI"], "log list /named")[1]
    run(environ["ROS_MASTER_URI"], "log get /named BAD")


def test_bags_of_others(run: Any, environ: dict[str, str], tmp_path: Path) -> None:
    path = tmp_path / "hostile.bag"
    kind: Any = load_message("std_msgs/String")
    header = {"type": kind._type + BAD, "md5sum": kind._md5sum, "message_definition": kind._full_text}
    writer = BagWriter(path)
    number = writer.add_connection("/topic" + WORSE, {name: text.encode() for name, text in header.items()})
    good = writer.add_connection("/good", {**{k: v.encode() for k, v in header.items()}, "type": b"std_msgs/String"})
    writer.write(number, 10**18, encode(kind("data" + WORSE)))
    writer.write(good, 10**18, encode(kind("data" + WORSE)))
    writer.close()
    for command in (
        "bag info {}", "bag info -y {}", "bag info -y -k topics {}", "bag check {}", "topic list -b {}",
        "topic echo -b {} /good", "topic echo -p -b {} /good", "topic echo -b {} /none", "bag info --json {}",
    ):  # fmt: skip
        out, err = run(environ["ROS_MASTER_URI"], command.format(path))[1:]
        assert "FORGED" in out + err or "none" in command, command


def test_frames_of_others(capsys: Any) -> None:
    assert_clean(
        format_tree([Frame("map", None, "", None, 0, 0, 0), Frame("a" + WORSE, "map", "/n" + WORSE, False, 1, 1, 2)], 3)
    )
    buffer = Buffer()
    moved: Any = load_message("geometry_msgs/TransformStamped")(child_frame_id="child" + WORSE)
    moved.header.frame_id, moved.transform.rotation.w = "parent" + WORSE, 1.0
    buffer.set_transform(moved, "/n" + WORSE)
    assert "FORGED" in buffer.all_frames_as_string()
    assert_clean(buffer.all_frames_as_string())
    moved.transform.rotation.w = 0.0
    buffer.set_transform(moved, "/n" + WORSE)
    assert_clean(capsys.readouterr().err)


def test_diagnostics_of_others() -> None:
    status: Any = load_message("diagnostic_msgs/DiagnosticStatus")
    pair: Any = load_message("diagnostic_msgs/KeyValue")
    array: Any = load_message("diagnostic_msgs/DiagnosticArray")
    values = [pair(key="k" + WORSE, value="v" + WORSE)]
    one = status(level=2, name="n" + WORSE, message="m" + WORSE, hardware_id="h" + WORSE, values=values)
    lines = list(status_lines(array(status=[one]), [one], detail=True, coloured=False))
    assert len(lines) >= 4
    assert_clean("\n".join(lines))


def test_on_a_terminal_the_commands_own_colours_pass_and_nothing_else() -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    terminal, file = Terminal(), io.StringIO()
    with closing(terminal), closing(file):
        for stream in (CleanStream(terminal), CleanStream(file)):
            print("\x1b[31mred\x1b[0m", WORSE, file=stream)
        assert terminal.getvalue().startswith("\x1b[31mred\x1b[0m \\x9b31m")
        assert "\x1b]" not in terminal.getvalue() and "\x07" not in terminal.getvalue()
        assert file.getvalue().startswith("\\x1b[31mred\\x1b[0m")
        assert CleanStream(file).exact is file and CleanStream(terminal).exact is not terminal
