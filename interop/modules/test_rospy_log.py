"""rospy's log: the same program on stock's modules and on ours, what it prints, writes and publishes
(P33-P39, N31)."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from faces import FACES, command, environ, run, same, start
from harness import Master, Process
from rospy_programs import TOOLS

HEAD = "import rospy\n" + TOOLS
MASTERS = ("ours",)

LOG = """
from rosgraph_msgs.msg import Log
rospy.loginfo("unseen before init_node")
rospy.logwarn("before %s", "init_node")
rospy.logerr_once("once before")
rospy.init_node("logs")
got = []
def take(m):
    if m.name == "/logs" and m.file.startswith("program"):
        got.append(m)
s = rospy.Subscriber("/rosout", Log, take)
until(lambda: s.get_num_connections())
rosout = rospy.topics.get_topic_manager().get_publisher_impl("/rosout")
until(lambda: rosout.get_num_connections() > 1)  # the node rosout and this one
def helper():
    rospy.loginfo("in a function %d", 5)
class Robot:
    def method(self):
        rospy.logwarn("in a method")
helper()
Robot().method()
rospy.logdebug("not shown")
rospy.logerr("%s and %s", "one", 2)
rospy.logfatal("fatal")
rospy.loginfo("100% plain")
rospy.loginfo({"a": 1})
rospy.loginfo("with a name", logger_name="sub")
rospy.logout("out")
rospy.loginfo("extra", extra={"x": 1})
try:
    1 / 0
except ZeroDivisionError:
    rospy.logerr("trace", exc_info=True)
for k in range(4):
    rospy.loginfo_once("once %d", k)
    rospy.logwarn_throttle(100, "throttle %d" % k)
    rospy.logerr_throttle_identical(100, "identical %d" % (k // 2))
    if k % 2:
        rospy.loginfo_once("other place %d", k)
t("wrong", lambda: rospy.loginfo("%d", "x"))
t("wrong", lambda: rospy.loginfo("x", unknown=1) if False else None)
logging.getLogger("rosout").setLevel(logging.DEBUG)
rospy.logdebug("now shown")
logging.getLogger("rosout").setLevel(logging.INFO)
logging.getLogger("rosout").warning("through Python's logger %s", 1)
handler = logging.StreamHandler(sys.stdout)
handler.setFormatter(logging.Formatter("HANDLER %(levelname)s %(name)s %(message)s %(funcName)s %(lineno)d"))
logging.getLogger("rosout").addHandler(handler)
rospy.logwarn("to both")
rospy.loginfo("last")
until(lambda: any(m.msg == "last" for m in got))
order = sorted(got, key=lambda m: m.header.seq)
for m in order:
    print(m.level, m.name, re_path(repr(m.msg)), re_path(m.file), m.function, m.line, "/rosout" in m.topics)
"""
LOG = 'import re\nre_path = lambda file: re.sub("program_[a-z]+", "program", file)\n' + LOG

SERVICES = """
from roscpp.srv import GetLoggers, SetLoggerLevel
rospy.init_node("levels", log_level=rospy.WARN)
get = rospy.ServiceProxy("~get_loggers", GetLoggers)
set = rospy.ServiceProxy("~set_logger_level", SetLoggerLevel)
def levels():
    return {logger.name: logger.level for logger in get().loggers}
t("levels", lambda: [levels()[name] for name in ("rosout", "rospy")])
rospy.loginfo("hidden")
t("set", lambda: str(set("rosout", "debug")))
t("levels", lambda: levels()["rosout"])
rospy.logdebug("debug")
set("rosout", "fatal")
rospy.logerr("hidden, too")
set("rosout", "INFO")
rospy.loginfo("info")
set("own.logger", "warn")
t("own", lambda: logging.getLogger("own.logger").getEffectiveLevel())
from rospy.logger_level_service_caller import LoggerLevelServiceCaller
caller = LoggerLevelServiceCaller()
t("caller", lambda: (caller.get_levels(), "/levels" in caller.get_node_names()))
t("caller", lambda: "rosout" in caller.get_loggers("/levels"))
t("caller", lambda: (caller.send_logger_change_message("/levels", "rosout", "error"), levels()["rosout"]))
"""

SHOWN = """
rospy.init_node("shown")
def place():
    rospy.loginfo("to stdout")
place()
rospy.logwarn("to stderr")
"""

FILE = """
rospy.init_node("to_file")
rospy.loginfo("information")
rospy.logwarn("two\\nlines")
rospy.logdebug("hidden")
logging.getLogger("other").info("other logger %d", 3)
logging.info("root logger")
logging.getLogger("other").debug("hidden")
try:
    1 / 0
except ZeroDivisionError:
    rospy.logerr("trace", exc_info=True)
"""

CONFIGURED = """
rospy.init_node("configured")
logging.getLogger("rospy.internal").setLevel(logging.CRITICAL)  # stock may lose a race at its end, and say so
rospy.loginfo("one")
rospy.logwarn("two", logger_name="sub")
logging.getLogger("other").error("three")
"""
CONFIG = """
[loggers]
keys=root,rosout
[handlers]
keys=own
[formatters]
keys=own
[logger_root]
level=ERROR
handlers=own
[logger_rosout]
level=WARN
handlers=own
propagate=0
qualname=rosout
[handler_own]
class=StreamHandler
level=DEBUG
formatter=own
args=(sys.stdout,)
[formatter_own]
format=OWN %(name)s %(levelname)s %(message)s
"""


def shown(text: str) -> str:
    """Return a text without what differs from run to run."""
    return re.sub(r"program_(?:ours|stock)(?:_\d+)?|\d{10}\.\d+", "X", text)


def test_messages(launcher: Master) -> None:
    said = same(launcher, HEAD + LOG, ROSCONSOLE_FORMAT="${severity} ${message} ${logger} ${line} ${function} ${node}")
    assert "ZeroDivisionError" in said and "HANDLER WARNING rosout to both" in said


def test_levels(launcher: Master) -> None:
    answers = [run(face, launcher, HEAD + SERVICES, ROSCONSOLE_FORMAT="${severity} ${message}") for face in FACES]
    stock, ours = (re.sub(r"DEBUG (?!debug).*\n", "", answer) for answer in answers)
    assert ours == stock and "DEBUG debug" in ours and "hidden" not in ours


@pytest.mark.parametrize(
    "form", [None, "[${severity}] ${walltime:%Y} ${time:%Y}: ${message} ${file}:${line} ${thread}"]
)
def test_terminal(launcher: Master, form: str | None) -> None:
    said = []
    for face in FACES:
        program = start(face, launcher, HEAD + SHOWN, ROSCONSOLE_FORMAT=form)
        assert program.wait() == 0
        said.append(re.sub(r"\d{12,}", "T", shown(program.transcript())))
    assert said[0] == said[1] and "to stdout" in said[0] and "to stderr" in said[0]


def test_file(launcher: Master, tmp_path: Path) -> None:
    texts = []
    for face in FACES:
        program = start(face, launcher, HEAD + FILE, ROS_LOG_DIR=str(tmp_path / face))
        assert program.wait() == 0
        text = (tmp_path / face / "to_file.log").read_text()
        lines = [line for line in text.splitlines() if not re.match(r"\[(rospy|xmlrpc|rosgraph)", line)]
        assert all(re.match(r"\[[\w.]+\]\[\w+\] \d{4}-\d\d-\d\d \d\d:\d\d:\d\d,\d\d\d: ", line) for line in lines[:1])
        kept = [re.sub(r"\d{4}-\d\d-\d\d [\d:]+,\d+", "D", line) for line in lines if line[:1] == "["]
        texts.append([line for line in kept if "set before" not in line])
    assert texts[0] == texts[1]
    assert texts[0][0] == "[rosout][INFO] D: information" and "[other][INFO] D: other logger 3" in texts[0]


def test_configuration_file(launcher: Master, tmp_path: Path) -> None:
    (tmp_path / "python_logging.conf").write_text(CONFIG)
    said = same(launcher, HEAD + CONFIGURED, ROS_PYTHON_LOG_CONFIG_FILE=str(tmp_path / "python_logging.conf"))
    assert said == "OWN rosout.sub WARNING two\nOWN other ERROR three\n"


@pytest.mark.parametrize("face", FACES)
def test_name_of_the_file(launcher: Master, tmp_path: Path, face: str) -> None:
    program = tmp_path / "program.py"
    program.write_text(HEAD + FILE)
    log = tmp_path / "own.log"
    done = Process([*command(face, program), f"__log:={log}"], environ(face, launcher), label=face)
    try:
        assert done.wait() == 0
    finally:
        done.close()
    assert "information" in log.read_text()


OWN_HANDLERS = """
import logging, sys
import rospy
def add(name, stream):
    handler = logging.StreamHandler(stream)
    handler.setFormatter(logging.Formatter("own %(name)s %(message)s"))
    logging.getLogger(name).addHandler(handler)
when, name, stream = sys.argv[1:]
logging.raiseExceptions = False
if when == "basic":
    logging.basicConfig(level=logging.INFO, stream=getattr(sys, stream))
if when == "before":
    add(name, getattr(sys, stream))
rospy.init_node("handlers")
if when == "after":
    add(name, getattr(sys, stream))
    logging.basicConfig(level=logging.DEBUG)
rospy.loginfo("rospy's")
logging.getLogger("mine").warning("mine")
logging.warning("root's")
"""


@pytest.mark.parametrize("stream", ["stdout", "stderr"])
@pytest.mark.parametrize(
    "when", [("basic", ""), *((when, name) for when in ("before", "after") for name in ("", "rosout", "mine"))]
)
def test_no_message_comes_twice_with_handlers_of_the_program(
    launcher: Master, when: tuple[str, str], stream: str
) -> None:
    said = []
    for face in FACES:
        program = start(face, launcher, OWN_HANDLERS, *when, stream, ROSCONSOLE_FORMAT="${message}")
        assert program.wait() == 0
        lines = [line for line in program.lines if "rospy's" in line or "mine" in line or "root's" in line]
        said.append(sorted(lines))
    assert said[0] == said[1]
