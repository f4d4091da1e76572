"""log: what a node says, where, and how often (P33-P38, N31, O18)."""

from __future__ import annotations

import builtins
import os
import re
import signal
import threading
from pathlib import Path
from typing import Any

import pytest

from pyros1.ground.errors import ServiceError
from pyros1.ground.log_file import LogFile
from pyros1.ground.timing import Time
from pyros1.msgs.rosgraph_msgs.msg import Log as LogMessage
from pyros1.node.log.levels import DEBUG, ERROR, FATAL, INFO, WARN, level_from_name
from pyros1.node.log.logger import Log
from pyros1.node.log.sink import Destinations, LogSink, default_log_file
from pyros1.node.publishing.publisher import Publisher


class Setting:
    """A logger with a clock that the test turns."""

    def __init__(self, environ: dict[str, str] | None = None, path: str | None = None, level: int = INFO) -> None:
        self.time = 1000.0
        self.simulated = False
        self.records: list[Any] = []
        self.sink = LogSink("/n", environ or {}, path, lambda: (Time.from_sec(self.time), self.simulated))
        self.sink.publish = self.records.append
        self.log = Log(self.sink, level=level)

    @property
    def texts(self) -> list[str]:
        return [record.text for record in self.records]


@pytest.fixture
def setting() -> Setting:
    return Setting()


def test_levels_p37(capsys: Any) -> None:
    setting = Setting(level=DEBUG)
    for name in ("debug", "info", "warn", "warning", "error", "fatal"):
        getattr(setting.log, name)("a %s", name)
    assert (
        [record.level for record in setting.records] == [DEBUG, INFO, WARN, WARN, ERROR, FATAL] == [1, 2, 4, 4, 8, 16]
    )
    out, err = capsys.readouterr()
    assert re.fullmatch(r"\[DEBUG\] \[\d+\.\d{6}\]: a debug\n\[INFO\] \[\d+\.\d{6}\]: a info\n", out)
    assert re.fullmatch(r"(\[(WARN|ERROR|FATAL)\] \[\d+\.\d{6}\]: a \w+\n){4}", err)


def test_what_is_logged_while_a_message_is_written_comes_behind_it_in_order(setting: Setting) -> None:
    published = setting.records.append

    def publish(record: Any) -> None:
        published(record)
        if record.text == "outer":
            for text in ("first", "second", "third"):
                setting.log.info(text)

    setting.sink.publish = publish
    setting.log.info("outer")
    assert setting.texts == ["outer", "first", "second", "third"]


def test_notes_go_everywhere_but_to_the_terminal(tmp_path: Path, capsys: Any) -> None:
    setting = Setting(path=str(tmp_path / "n.log"))
    setting.log.note("hello 100%")
    setting.log.level = WARN
    setting.log.note("no")
    assert [(record.level, record.text, record.file) for record in setting.records] == [
        (INFO, "hello 100%", "test_log.py")
    ]
    setting.sink.close()
    assert "hello" in (tmp_path / "n.log").read_text()
    assert capsys.readouterr() == ("", "")


def test_lower_levels_are_left_out(setting: Setting) -> None:
    setting.log.debug("no %d", "never formatted")
    setting.log.level = ERROR
    setting.log.warn("no")
    setting.log.error("yes")
    assert setting.texts == ["yes"]


def test_printf_arguments_p33(setting: Setting) -> None:
    setting.log.info("%s is %.2f at 100%%", "x", 1.234)
    setting.log.info("no arguments: 100%")
    setting.log.info("wrong %d", "x")
    setting.log.info("too many", 1)
    setting.log.info(17)
    assert setting.texts[:2] == ["x is 1.23 at 100%", "no arguments: 100%"]
    assert setting.texts[2].startswith("wrong %d ('x',) (bad log arguments")
    assert setting.texts[3].startswith("too many (1,) (bad log arguments")
    assert setting.texts[4] == "17"


def test_where_it_was_logged_p36(setting: Setting) -> None:
    setting.log.info("here")
    setting.log.exception("there", ValueError("x"))
    for record in setting.records:
        assert (record.file, record.function) == ("test_log.py", "test_where_it_was_logged_p36")
    assert setting.records[1].line == setting.records[0].line + 1
    assert setting.texts[1] == "there\nValueError: x"


def test_exception_inside_an_except_block_as_in_logging(setting: Setting) -> None:
    try:
        raise ValueError("x is 100%")
    except ValueError as error:
        setting.log.exception("oops")
        setting.log.exception("no %s for %d", "robot", 3)
        setting.log.exception(error)
        setting.log.exception("behind", error)
    setting.log.exception("nothing is wrong")
    heads = [text.partition("\n")[0] for text in setting.texts]
    assert heads == ["oops", "no robot for 3", "x is 100%", "behind", "nothing is wrong"]
    for text in setting.texts[:4]:
        assert "\nTraceback (most recent call last):\n" in text and text.endswith("\nValueError: x is 100%")


def test_format_n31(capsys: Any) -> None:
    form = "${severity}|${message}|${logger}|${file}|${function}|${node}|${walltime:%Y}|${nonsense}|${time}"
    setting = Setting({"ROSCONSOLE_FORMAT": form})
    setting.simulated = True
    setting.log.named("child").info("hi")
    head, _, times = capsys.readouterr().out.rstrip("\n").rpartition("|")
    year = re.escape(head.split("|")[6])
    assert re.fullmatch(r"20\d\d", year)
    assert head == f"INFO|hi|rosout.child|{__file__}|test_format_n31|/n|{year}|${{nonsense}}"
    assert re.fullmatch(r"\d+\.\d{6}, 1000\.000000", times)


def test_throttle_and_once_p34(setting: Setting) -> None:
    for second in (1000, 1001, 1002, 1003, 1004.9, 1005, 10, 10.5):
        setting.time = second
        setting.log.info("throttled %g", second, throttle=2.0)
        setting.log.info("once", once=True)
    assert setting.texts == ["throttled 1000", "once", "throttled 1002", "throttled 1004.9", "throttled 10"]


def test_throttling_is_per_place(setting: Setting) -> None:
    for _ in range(3):
        setting.log.info("a", throttle=5.0)
        setting.log.info("b", throttle=5.0)
    assert setting.texts == ["a", "b"]


def test_children_have_their_own_level(setting: Setting) -> None:
    child = setting.log.named("parts").named("motor")
    assert child.name == "rosout.parts.motor"
    child.level = DEBUG
    child.debug("fine")
    setting.log.debug("coarse")
    assert setting.texts == ["fine"]
    assert setting.log.named("parts").named("motor").level == DEBUG, "the same logger"


def test_names_of_levels() -> None:
    assert [level_from_name(name) for name in ("debug", "Info", "WARN", "warning", "error", "critical", "FATAL")] == [
        1, 2, 4, 4, 8, 16, 16
    ]  # fmt: skip
    with pytest.raises(ValueError, match="'loud' is not a log level"):
        level_from_name("loud")


def test_colours_on_a_terminal_p35(monkeypatch: pytest.MonkeyPatch, setting: Setting) -> None:
    import io

    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    terminal = Terminal()
    monkeypatch.setattr("sys.stdout", terminal)
    monkeypatch.setattr("sys.stderr", terminal)
    setting.log.info("plain")
    setting.log.error("red")
    plain, red = terminal.getvalue().splitlines()
    assert "\x1b" not in plain
    assert red.startswith("\x1b[31m[ERROR]") and red.endswith("red\x1b[0m")


@pytest.mark.parametrize("broken", [None, "closed"])
def test_a_broken_terminal_stops_nobody(monkeypatch: pytest.MonkeyPatch, setting: Setting, broken: Any) -> None:
    import io

    stream = io.StringIO() if broken else None
    if stream is not None:
        stream.close()
    monkeypatch.setattr("sys.stdout", stream)
    setting.log.info("heard elsewhere")
    assert setting.texts == ["heard elsewhere"]


# Files ----------------------------------------------------------------------------------------------------------------


def test_log_file_p38(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "n.log"
    setting = Setting(path=str(path))
    assert not path.exists(), "made at the first line"
    setting.log.info("one")
    setting.log.warn("two ä")
    setting.sink.close()
    lines = path.read_text(encoding="utf-8").splitlines()
    assert re.fullmatch(r"\[rosout\]\[INFO\] \d{4}-\d\d-\d\d \d\d:\d\d:\d\d,\d{3}: one", lines[0])
    assert lines[1].endswith("two ä")
    setting.log.info("after the end")
    assert len(path.read_text(encoding="utf-8").splitlines()) == 2


def test_large_log_files_are_put_aside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.log.sink.MAX_FILE_SIZE", 100)
    path = tmp_path / "n.log"
    setting = Setting(path=str(path))
    for number in range(5):
        setting.log.info("%s", str(number) * 40)
    setting.sink.close()
    assert (tmp_path / "n.log.1").exists()
    assert path.stat().st_size <= 200


def test_a_log_file_that_cannot_be_written_is_told_once(tmp_path: Path, capsys: Any) -> None:
    (tmp_path / "file").write_text("")
    setting = Setting(path=str(tmp_path / "file" / "n.log"))
    setting.log.info("a")
    setting.log.info("b")
    assert setting.texts == ["a", "b"]
    assert capsys.readouterr().err.count("cannot write the log file") == 1


@pytest.mark.parametrize(
    ("environ", "special", "expected"),
    [
        ({"ROS_LOG_DIR": "/l", "ROS_HOME": "/h"}, {}, "/l/robot_arm.log"),
        ({"ROS_HOME": "/h"}, {}, "/h/log/robot_arm.log"),
        ({"ROS_HOME": "/h"}, {"__log": "/x/y.log"}, "/x/y.log"),
        ({}, {}, os.path.expanduser("~/.ros/log/robot_arm.log")),
    ],
)
def test_where_the_log_file_is_n14_n30(environ: dict[str, str], special: dict[str, str], expected: str) -> None:
    assert default_log_file("/robot/arm", environ, special) == expected


def test_a_node_writes_its_file(make_node: Any, environ: dict[str, str], tmp_path: Path) -> None:
    make_node("writer", namespace="/ns").log.info("in the file")
    assert "in the file" in (Path(environ["ROS_HOME"]) / "log" / "ns_writer.log").read_text()
    make_node("other", argv=[f"__log:={tmp_path}/other.log"]).log.info("in its own")
    assert "in its own" in (tmp_path / "other.log").read_text()


# /rosout and the logger services --------------------------------------------------------------------------------------


def test_rosout_p36_o18(make_node: Any, transport: str, collect: Any) -> None:
    got = collect()
    make_node("listener").subscribe("/rosout", LogMessage, got)
    node = make_node("talker")
    node.advertise("t", LogMessage)
    for topic in ("u", "t"):
        node.subscribe(topic, LogMessage, print)
    node.log.debug("not sent")
    node.log.warn("look: %d", 7)
    assert got.until(lambda items: [m for m in items if m.name == "/talker"])
    message = next(m for m in got.items if m.name == "/talker")
    assert (message.level, message.msg) == (LogMessage.WARN, "look: 7")
    assert (message.file, message.function) == ("test_log.py", "test_rosout_p36_o18") and message.line > 0
    assert {"/rosout", "/t", "/u"} <= set(message.topics)
    assert len(message.topics) == len(set(message.topics)), "one that it publishes and subscribes to is named once"
    assert message.header.stamp.secs > 1_000_000_000
    assert message._connection_header["latching"] == "1"


def test_a_node_that_publishes_no_log(make_node: Any) -> None:
    node = make_node("quiet", rosout=False)
    node.log.info("only here")
    node.advertise("t", LogMessage)
    publishers, _, services = node.master.get_system_state()
    assert [name for name, _ in publishers] == ["/t"]
    assert [name for name, _ in services] == ["/quiet/get_loggers", "/quiet/set_logger_level"]


def test_logger_services_o18(make_node: Any) -> None:
    node, tool = make_node("node", log_level="warn"), make_node("tool")
    node.log.named("motor")
    loggers = {item.name: item.level for item in tool.service("/node/get_loggers", "roscpp/GetLoggers")().loggers}
    assert loggers == {"rosout": "WARN", "rosout.motor": "WARN"}
    set_level = tool.service("/node/set_logger_level", "roscpp/SetLoggerLevel")
    set_level("rosout", "Debug")
    assert node.log.level == DEBUG
    set_level(logger="rosout.motor", level="ERROR")
    assert node.log.named("motor").level == ERROR
    with pytest.raises(ServiceError, match="'loud' is not a log level"):
        set_level("rosout", "loud")


def test_what_cannot_be_published_is_still_printed(make_node: Any, collect: Any, capsys: Any) -> None:
    got = collect()
    node = make_node("talker")
    node.subscribe("/rosout", LogMessage, got)
    node.log.info("half a character: \ud800")
    node.log.info("next")
    assert got.until(lambda items: "next" in [m.msg for m in items])


def test_log_after_the_end(make_node: Any, capsys: Any) -> None:
    node = make_node("talker")
    node.shutdown()
    node.log.info("goodbye")
    assert "goodbye" in capsys.readouterr().out


def test_an_error_is_told_though_no_file_can_be_opened(
    make_node: Any, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    node = make_node("node")
    real = builtins.__import__

    def refuse(name: str, *rest: Any, **more: Any) -> Any:
        if name == "traceback":
            raise OSError(24, "Too many open files")
        return real(name, *rest, **more)

    def publish(*_: Any) -> None:
        raise OSError(24, "Too many open files")

    with monkeypatch.context() as patch:
        patch.setattr(Publisher, "publish", publish)
        patch.setattr(builtins, "__import__", refuse)
        node.log.exception("bad callback", ValueError("five"))
    said = capfd.readouterr().err
    assert "bad callback\nValueError: five" in said and "cannot publish a log message" in said


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
def test_a_forked_process_may_log_whatever_other_threads_were_doing(
    tmp_path: Path, in_thread: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    setting = Setting(path=str(tmp_path / "n.log"))
    setting.log.info("before")
    sink = setting.sink
    held, go_on = threading.Semaphore(0), threading.Event()
    write = LogFile.write

    def hold() -> None:
        if threading.current_thread().name == "test":
            held.release()
            go_on.wait(20)

    class Place:
        """Is looked up for long."""

        def __hash__(self) -> int:
            hold()
            return 1

    monkeypatch.setattr(LogFile, "write", lambda file, text: (hold(), write(file, text)))
    holders = [in_thread(setting.log.info, "held"), in_thread(sink.repeats.log, Place(), "text", lambda _: None)]
    assert held.acquire(timeout=10) and held.acquire(timeout=10)
    child = os.fork()
    if not child:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(5)  # ends it if it hangs
        setting.log.info("in the child")
        setting.log.peer_event(WARN, "of a peer")
        sink.close()
        os._exit(0)
    _, status = os.waitpid(child, 0)
    go_on.set()
    for holder in holders:
        holder.join()
    setting.log.info("after")
    sink.close()
    assert status == 0
    lines = (tmp_path / "n.log").read_text().splitlines()
    assert [line.partition(": ")[2] for line in lines] == ["before", "in the child", "of a peer", "held", "after"]


def test_a_signal_handler_that_has_interrupted_a_write_may_close_the_log(
    tmp_path: Path, in_thread: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    setting = Setting(path=str(tmp_path / "n.log"))
    write = LogFile.write
    monkeypatch.setattr(LogFile, "write", lambda file, text: (setting.sink.close(), write(file, text)))
    in_thread(setting.log.info, "interrupted").join()
    setting.sink.close()
    assert "interrupted" in (tmp_path / "n.log").read_text()


def test_messages_of_another_logging_system(tmp_path: Path, capsys: Any) -> None:
    setting = Setting({"ROSCONSOLE_FORMAT": "${logger} ${message} ${file} ${line} ${function}"}, str(tmp_path / "log"))
    place: dict[str, Any] = {"path": "/folder/own.py", "line": 7, "function": "f"}
    setting.log.log_record(FATAL, "all", **place)
    setting.log.log_record(WARN, "file", **place, name="other", destinations=Destinations(terminal=False, rosout=False))
    setting.log.log_record(INFO, "rosout", **place, destinations=Destinations(terminal=False, file=False))
    assert capsys.readouterr().err == "rosout all /folder/own.py 7 f\n"
    assert setting.texts == ["all", "rosout"] and setting.records[0].file == "own.py"
    setting.sink.close()
    lines = (tmp_path / "log").read_text().splitlines()
    assert [re.sub(r"[\d:,-]+ [\d:,-]+", "D", line) for line in lines] == [
        "[rosout][CRITICAL] D all",
        "[other][WARNING] D file",
    ]


def test_errors_are_explained(capsys: Any) -> None:
    setting = Setting()
    setting.log.explain_with(lambda error: "\nwrite x" if isinstance(error, NameError) else "")
    for error in (NameError("no"), ValueError("no")):
        setting.log.exception("it failed", error=error)
    assert [text.splitlines()[-1] for text in setting.texts] == ["write x", "ValueError: no"]
    assert all(text.startswith("it failed\n") for text in setting.texts)


def test_levels_that_are_kept_elsewhere(capsys: Any) -> None:
    setting, levels = Setting(), {"rosout": ERROR}
    setting.log.use_levels(levels)
    setting.log.warn("hidden")
    levels["rosout"] = DEBUG
    setting.log.debug("shown")
    setting.log.level = FATAL
    assert levels["rosout"] == FATAL and setting.texts == ["shown"]


def without(forbidden: object, method: Any) -> Any:
    """Return a method that must not be called for one object."""

    def call(self: object, *args: Any) -> Any:
        assert self is not forbidden
        return method(self, *args)

    return call


@pytest.mark.parametrize("kind", ["info", "peer"])
def test_a_forked_process_logs_with_locks_of_its_own(
    setting: Setting, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    """The parent's may be held by threads that do not exist there."""
    setting.log.info("before")
    repeats, pid = setting.sink.repeats, os.getpid()
    monkeypatch.setattr("pyros1.node.log.sink.os.getpid", lambda: pid + 1)
    monkeypatch.setattr(type(repeats), "log", without(repeats, type(repeats).log))
    if kind == "info":
        setting.log.info("after")
    else:
        setting.log.peer_event(INFO, "after")
    again = setting.sink.repeats
    assert again is not repeats
    setting.log.info("later")
    assert setting.sink.repeats is again, "once in each process"
    assert setting.texts == ["before", "after", "later"]
