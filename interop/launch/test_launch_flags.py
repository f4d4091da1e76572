"""The flags of the launcher and what it leaves with the master, through stock roslaunch and ours (X79, X81, L153-L175).

Each test asks the same of both; a difference that is meant is written down where it shows.
"""

from __future__ import annotations

import os
import pty
import re
import signal
import subprocess
import sys
import xml.etree.ElementTree
import xmlrpc.client
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from harness import DEADLINE, SOURCE, free_port, until

pytestmark = pytest.mark.ours_only

PACKAGE = """<package format="2"><name>{}</name><version>1.0.0</version><description>Nodes.</description>
<maintainer email="a@example.org">a</maintainer><license>BSD</license>{}</package>"""
SAY = """#!/bin/sh
[ "$1" = deaf ] && trap '' INT TERM
[ "$1" = stay ] && trap 'exit 0' INT
echo "said $1"
touch "$SAID/$1"
case $1 in once) exit 0;; fail) exit 3;; esac
while :; do sleep 0.05; done
"""
NODE = '<node pkg="telling" type="say" name="{0}_{1}" args="{0}"{2}/>'
LAUNCH = {
    "once": '<param name="p" value="1"/>' + NODE.format("once", "a", "") + NODE.format("once", "b", ' output="screen"'),
    "stay": NODE.format("stay", "a", ""),
    "fail": NODE.format("stay", "a", "") + NODE.format("fail", "b", ""),
    "deaf": NODE.format("deaf", "a", ""),
    "remote": '<machine name="m" address="192.0.2.1"/>'
    + NODE.format("once", "a", "")
    + NODE.format("once", "b", ' machine="m"'),
}
CHECKED = {
    "good": '<launch><arg name="k" default="say"/><node pkg="telling" type="$(arg k)" name="z"/></launch>',
    "inc": '<launch><include file="$(dirname)/good.launch"/><test pkg="rostest" type="hztest" test-name="t"/></launch>',
    "sub/undeclared": '<launch><node pkg="topic_tools" type="relay" name="a"/></launch>',
    "needs": '<launch><arg name="x"/><node pkg="telling" type="$(arg x)" name="a"/></launch>',
    "misspelt": '<launch><node pkg="telling" type="sya" name="a"/></launch>',
    "no_name": "<launch><node/></launch>",
    "not_xml": "<launch><param",
}
WHO = pytest.mark.parametrize("who", ["stock", "ours"])


@dataclass
class Done:
    """A launch that is over."""

    code: int
    out: str
    err: str
    log: Path


class Place:
    """A folder with launch files, and a port for a master that the launcher starts."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.said = folder / "said"
        self.said.mkdir()
        self.uri = f"http://localhost:{free_port()}"
        (folder / "telling").mkdir()
        (folder / "telling" / "package.xml").write_text(PACKAGE.format("telling", ""))
        (folder / "telling" / "say").write_text(SAY)
        (folder / "telling" / "say").chmod(0o755)
        for name, text in LAUNCH.items():
            (folder / f"{name}.launch").write_text(f"<launch>{text}</launch>")
        checked = folder / "chk" / "launch"
        (checked / "sub").mkdir(parents=True)
        depends = "<exec_depend>telling</exec_depend><test_depend>rostest</test_depend>"
        (folder / "chk" / "package.xml").write_text(PACKAGE.format("chk", depends))
        for name, text in CHECKED.items():
            (checked / f"{name}.launch").write_text(text)

    @property
    def environ(self) -> dict[str, str]:
        paths = [str(SOURCE), *filter(None, [os.environ.get("PYTHONPATH")])]
        return {
            **os.environ,
            "PYTHONPATH": os.pathsep.join(paths),
            "PYTHONUNBUFFERED": "1",
            "ROS_HOME": str(self.folder / "home"),
            "ROS_LOG_DIR": str(self.folder / "log"),
            "ROS_HOSTNAME": "localhost",
            "ROS_MASTER_URI": self.uri,
            "ROS_PACKAGE_PATH": f"{self.folder}:/usr/share",
            "SAID": str(self.said),
        }

    def start(self, who: str, *words: str, **more: Any) -> subprocess.Popen[str]:
        """Start a launcher."""
        command = ["/usr/bin/roslaunch"] if who == "stock" else [sys.executable, "-m", "pyros1", "launch"]
        pipe = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        return subprocess.Popen([*command, *words], cwd=self.folder, env=self.environ, text=True, **{**pipe, **more})

    def run(self, who: str, *words: str, ready: Callable[[], Any] = lambda: False) -> Done:
        """Run a launcher until it ends, or until *ready*, and Ctrl-C."""
        with self.start(who, *words) as launcher:
            until(lambda: launcher.poll() is not None or (ready() and self.settled(who)), "it has ended or is ready")
            if launcher.poll() is None:
                launcher.send_signal(signal.SIGINT)
            try:
                out, err = launcher.communicate(timeout=DEADLINE)
            finally:
                launcher.kill()
        out = re.sub(r"\033(\[\d*m|\]2;.*?\007)", "", out)
        err = re.sub(r"\033\[\d*m", "", err)
        return Done(launcher.returncode, out, err, self.folder / "log" / "latest")

    def settled(self, who: str) -> bool:
        """Return whether Ctrl-C ends a launcher well: stock's may hang while it starts a node, or leave out the end."""
        logs = (self.folder / "log" / "latest").glob("roslaunch-*.log")
        return who == "ours" or any(re.search(": spin$", file.read_text(), re.MULTILINE) for file in logs)

    def has_said(self, word: str) -> Callable[[], bool]:
        """Return what tells whether a node has started."""
        return (self.said / word).exists

    def tool(self, *words: str) -> subprocess.CompletedProcess[str]:
        """Run another program there."""
        return subprocess.run(
            words, cwd=self.folder / "chk", env=self.environ, capture_output=True, text=True, timeout=60, check=False
        )


@pytest.fixture
def place(tmp_path: Path) -> Place:
    return Place(tmp_path)


@pytest.fixture
def running(place: Place) -> Iterator[xmlrpc.client.ServerProxy]:
    """A stock master that the launchers of *place* find."""
    with start_master(place) as process:
        try:
            with xmlrpc.client.ServerProxy(place.uri) as master:
                until(lambda: _answers(master), "the master answers")
                yield master
        finally:
            process.terminate()


def start_master(place: Place) -> subprocess.Popen[str]:
    """Start a stock master."""
    return subprocess.Popen(
        ["rosmaster", "--core", "-p", place.uri.rpartition(":")[2]],
        env=place.environ,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        text=True,
    )


def _answers(master: xmlrpc.client.ServerProxy) -> bool:
    try:
        master.getPid("/test")
    except OSError:
        return False
    return True


@WHO
def test_the_run_id_of_a_running_master_is_taken_x79_l153(place: Place, running: Any, who: str) -> None:
    running.setParam("/test", "/run_id", "given")
    done = place.run(who, "once.launch")
    assert done.code == 0 and f"{place.folder}/log/given/roslaunch-" in done.out.splitlines()[0]
    assert "setting /run_id" not in done.out and done.log.resolve().name == "given"
    assert place.run(who, "--run_id", "given", "once.launch").code == 0
    done = place.run(who, "--run_id", "other", "once.launch")
    assert done.code == 1
    assert "RLException: run_id on parameter server does not match declared run_id: given vs other" in done.err


@WHO
def test_a_run_id_of_ones_own_l153(place: Place, running: Any, who: str) -> None:
    done = place.run(who, "--run_id", "mine", "once.launch")
    assert "setting /run_id to mine\n" in done.out
    assert running.getParam("/test", "/run_id")[2] == "mine"
    assert done.log.resolve().name == "mine"


@WHO
def test_the_launcher_tells_the_master_where_it_is_x81(place: Place, running: Any, who: str) -> None:
    with place.start(who, "stay.launch", stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as launcher:
        until(place.has_said("stay"), "the node has started")
        ((name, uri),) = running.getParam("/test", "/roslaunch/uris")[2].items()
        with xmlrpc.client.ServerProxy(uri) as server:
            pid: Any = server.get_pid()
        launcher.send_signal(signal.SIGINT)
        launcher.wait(DEADLINE)
    assert re.fullmatch(r"http://localhost:\d+/", uri) and name == f"host_localhost__{uri[17:-1]}"
    assert int(pid[2]) == launcher.pid
    # Stock leaves it behind.
    assert running.hasParam("/test", f"/roslaunch/uris/{name}")[2] == (who == "stock")


@WHO
def test_local_leaves_out_remote_nodes_l154(place: Place, running: Any, who: str) -> None:
    done = place.run(who, "--local", "remote.launch")
    assert done.code == 0 and "local only launch specified, will not launch remote nodes" in done.out
    assert "once_a (telling/say)" in done.out and "once_b" not in done.out and "MACHINES" not in done.out


@WHO
@pytest.mark.parametrize(
    ("flags", "on_screen"),
    [([], 1), (["--screen"], 2), (["--log"], 0), (["--screen", "--log"], 0)],
    ids=["as_they_say", "screen", "log", "both"],
)
def test_output_goes_where_the_flags_say_l155_l157(
    place: Place, running: Any, who: str, flags: list[str], on_screen: int
) -> None:
    done = place.run(who, *flags, "once.launch")
    assert done.code == 0 and done.out.count("said once") == on_screen
    texts = [path.read_text() for path in done.log.glob("*-stdout.log")]
    assert texts == ["said once\n"] * (2 - on_screen)


@WHO
def test_every_node_can_be_made_required_l156(place: Place, running: Any, who: str) -> None:
    done = place.run(who, "--required", "fail.launch")
    assert "REQUIRED process [fail_b-2] has died!\n" in done.err and "Initiating shutdown!\n" in done.err
    assert "exit code 3" in done.err
    assert done.code == (0 if who == "stock" else 1)


@WHO
def test_the_master_is_waited_for_l158(place: Place, new_process: Callable[..., Any], who: str) -> None:
    launcher = new_process(place.start(who, "--wait", "once.launch"))
    assert launcher.stdout.readline() == "roscore/master is not yet running, will wait for it to start\n"
    if who == "stock":  # which may hang when the master comes, depending on its Python
        return
    new_process(start_master(place))
    out, _ = launcher.communicate(timeout=DEADLINE)
    assert out.startswith("master has started, initiating launch\n")
    assert launcher.returncode == 0 and "auto-starting" not in out


@pytest.fixture
def new_process() -> Iterator[Callable[..., Any]]:
    """Takes note of a process, which ends with the test."""
    noted: list[subprocess.Popen[str]] = []

    def note(process: subprocess.Popen[str]) -> subprocess.Popen[str]:
        noted.append(process)
        return process

    yield note
    for process in noted:
        process.kill()
        process.communicate()


@WHO
def test_the_port_of_the_master_started_l159(place: Place, running: Any, who: str) -> None:
    uri = f"http://localhost:{free_port()}/"  # the running master is another one
    done = place.run(who, "-p", uri.rpartition(":")[2].rstrip("/"), "stay.launch", ready=place.has_said("stay"))
    assert done.code == 0 and f"ROS_MASTER_URI={uri}\n" in done.out and "auto-starting new master\n" in done.out
    assert not running.hasParam("/test", "/run_id")[2]


@WHO
def test_core_alone_l160(place: Place, who: str) -> None:
    # Stock does not look at ROS_MASTER_URI for the port.
    port = place.uri.rpartition(":")[2]
    with xmlrpc.client.ServerProxy(place.uri) as master:

        def complete() -> bool:
            try:
                state: Any = master.getSystemState("/test")
            except OSError:
                return False
            return ["/rosout_agg", ["/rosout"]] in state[2][0]

        done = place.run(who, "--core", "-p", port, ready=complete)
    assert done.code == 0
    for line in ("auto-starting new master", "started core service [/rosout]", "[master] killing on exit", "done"):
        assert f"{line}\n" in done.out
    assert "WARNING" not in done.err and re.search(r"^ros_comm version 1\.1[56]\.\d+$", done.out, re.MULTILINE)


@WHO
def test_the_pid_file_is_there_while_it_runs_l161(place: Place, running: Any, who: str) -> None:
    file = place.folder / "pid"
    with place.start(who, f"--pid={file}", "stay.launch", stdout=subprocess.DEVNULL) as launcher:
        until(place.has_said("stay"), "the node has started")
        text = file.read_text()
        launcher.send_signal(signal.SIGINT)
        launcher.communicate(timeout=DEADLINE)
    assert int(text) == launcher.pid and not file.exists()
    assert place.run(who, "--pid=/no/such/folder/pid", "once.launch").code == 1


def test_what_is_read_is_told_l162(place: Place, running: Any) -> None:
    told = {}
    for who in ("stock", "ours"):
        out = place.run(who, "-v", "once.launch").out.splitlines()
        told[who] = sorted(line for line in out if line.startswith(("... loading XML", "Added ")))
    core = ("roscore.xml", "/rosversion", "/rosdistro", "core node")
    stock = [line for line in told["stock"] if not any(word in line for word in core)]
    # Stock prints the path as it was written.
    assert [line.replace(f"{place.folder}/", "") for line in told["ours"]] == stock


@WHO
def test_no_summary_l163(place: Place, running: Any, who: str) -> None:
    assert "SUMMARY" in place.run(who, "once.launch").out
    done = place.run(who, "--no-summary", "once.launch")
    assert done.code == 0 and not re.search("SUMMARY|PARAMETERS|NODES", done.out)


@WHO
def test_the_log_check_can_be_skipped_l165(place: Place, running: Any, who: str) -> None:
    done = place.run(who, "--skip-log-check", "once.launch")
    assert done.code == 0 and "disk usage" not in done.out
    if who == "ours":  # which never looks: the folder may be large
        assert "disk usage" not in place.run(who, "once.launch").out


@WHO
@pytest.mark.parametrize("flags", [[], ["--disable-title"]], ids=["title", "none"])
def test_the_title_of_the_terminal_l167(place: Place, running: Any, who: str, flags: list[str]) -> None:
    ours, theirs = pty.openpty()
    with place.start(who, *flags, "once.launch", stdin=theirs, stdout=theirs, stderr=theirs) as launcher:
        os.close(theirs)
        text = b""
        while chunk := _read_terminal(ours):
            text += chunk
    os.close(ours)
    titles = [b"once.launch", b"once.launch " + place.uri.encode()]
    assert launcher.returncode == 0
    assert re.findall(rb"\033\]2;(.*?)\007", text) == ([] if flags else titles)
    assert b"\033[1mstarted roslaunch server " in text


def _read_terminal(number: int) -> bytes:
    try:
        return os.read(number, 4096)
    except OSError:  # nobody has the other side any more
        return b""


@WHO
@pytest.mark.parametrize("flags", [["-w", "0"], ["-w", "7"], ["-t", "2.5"]], ids=" ".join)
def test_settings_of_the_master_started_l168_l169(place: Place, who: str, flags: list[str]) -> None:
    done = place.run(who, *flags, "stay.launch", ready=place.has_said("stay"))
    assert done.code == 0 and "auto-starting new master\n" in done.out


@WHO
@pytest.mark.parametrize("flag", ["--sigint-timeout=0", "--sigterm-timeout=-1", "--sigint-timeout=-1", "--timeout=0"])
def test_no_time_is_no_setting_l169_l171_l172(place: Place, who: str, flag: str) -> None:
    done = place.run(who, flag, "stay.launch", ready=place.has_said("stay"))
    if (who, flag) == ("stock", "--timeout=0"):  # its master may or may not come up
        return
    assert done.code == 1 and "timeout must be a positive number, received " in done.err
    assert not place.has_said("stay")()


@WHO
@pytest.mark.parametrize(
    ("level", "seen"),
    [("debug", {"DEBUG", "INFO"}), ("INFO", {"INFO"}), ("warn", set()), ("fatal", set()), ("nonsense", {"INFO"})],
)
def test_what_the_master_logs_l170(place: Place, who: str, level: str, seen: set[str]) -> None:
    done = place.run(who, "--master-logger-level", level, "stay.launch", ready=place.has_said("stay"))
    levels = re.findall(r"^\[rosmaster\.master\]\[(\w+)\]", (done.log / "master.log").read_text(), re.MULTILINE)
    assert done.code == 0 and set(levels) == seen


@WHO
def test_how_long_nodes_have_l171_l172(place: Place, running: Any, who: str) -> None:
    flags = ["--sigint-timeout=0.2", "--sigterm-timeout=0.2"]  # the defaults would take longer than the test may
    done = place.run(who, *flags, "deaf.launch", ready=place.has_said("deaf"))
    told = re.findall(r"\[deaf_a-1\] (killing on exit|escalating to SIG\w+)", done.out + done.err)
    assert told == ["killing on exit", "escalating to SIGTERM", "escalating to SIGKILL"]


CHECK = ["/usr/bin/python3", "/usr/share/roslaunch/scripts/roslaunch-check"]
OURS = [sys.executable, "-m", "pyros1", "launch"]


@pytest.mark.parametrize(
    "words",
    [
        *([f"launch/{name}.launch"] for name in CHECKED),
        ["launch"],
        ["launch/sub"],
        ["."],
        ["launch/needs.launch", "x:=say"],
        ["launch/needs.launch", "FOO=say"],
        [],
    ],
    ids=" ".join,
)
@pytest.mark.skipif(not Path(CHECK[1]).exists(), reason="roslaunch-check is not installed")
def test_checks_find_the_same_l174(place: Place, words: list[str]) -> None:
    found = []
    for command in (CHECK, [*OURS, "--check"]):
        file = place.folder / "results.xml"
        file.unlink(missing_ok=True)
        done = place.tool(*command, "-o", str(file), *words)
        lines = sorted(line for line in done.stdout.splitlines())
        failed = sorted(re.findall(r"^\[(.*)\]:$", done.stderr, re.MULTILINE))
        result: list[Any] = [done.returncode, lines, failed]
        if file.exists():
            suite = xml.etree.ElementTree.parse(file).getroot()
            result += [suite.get(key) for key in ("name", "tests", "failures", "errors")]
            result += [(case.get("classname"), case.get("name"), len(case)) for case in suite.iter("testcase")]
        found.append(result)
    assert found[0] == found[1]


@pytest.mark.parametrize(("stock", "ours"), [("-t", "--use-test-depends"), ("-i", "--ignore-unset-args")])
@pytest.mark.skipif(not Path(CHECK[1]).exists(), reason="roslaunch-check is not installed")
def test_flags_of_checks_l174(place: Place, stock: str, ours: str) -> None:
    for name in ("inc", "needs", "misspelt"):
        words = ["-o", str(place.folder / "results.xml"), f"launch/{name}.launch"]
        theirs = place.tool(*CHECK, stock, *words)
        assert place.tool(*OURS, "--check", ours, *words).returncode == theirs.returncode, theirs.stderr


@pytest.mark.parametrize("flags", [[], ["-v"], ["-w"], ["-v", "-w"]], ids=["none", "v", "w", "vw"])
@pytest.mark.parametrize("names", [*([name] for name in CHECKED), ["good", "sub/undeclared"], ["none"], []], ids=str)
def test_needs_of_files_l175(place: Place, flags: list[str], names: list[str]) -> None:
    words = [*flags, *(f"launch/{name}.launch" for name in names)]
    theirs, mine = place.tool("roslaunch-deps", *words), place.tool(*OURS, "--deps", *words)
    assert mine.returncode == theirs.returncode, mine.stderr
    if not theirs.returncode:  # else stock's reason is on stdout; the names come in any order
        both = [[sorted(line.split()) for line in done.stdout.splitlines()] for done in (theirs, mine)]
        assert both[0] == both[1]


@pytest.mark.parametrize(
    "words",
    [
        ["launch/good.launch"],
        ["launch/not_xml.launch"],
        ["chk", "good.launch", "k:="],
        ["chk", "needs.launch"],
        ["none"],
        [],
    ],
    ids=" ".join,
)
def test_arguments_for_shells_l175(place: Place, words: list[str]) -> None:
    theirs, mine = place.tool("roslaunch-complete", *words), place.tool(*OURS, "--complete", *words)
    assert (mine.returncode, mine.stdout) == (theirs.returncode, theirs.stdout)


def test_folder_of_the_logs_l175(place: Place, running: Any) -> None:
    for _ in range(2):
        theirs, mine = place.tool("roslaunch-logs"), place.tool(*OURS, "--logs")
        assert (mine.returncode, mine.stdout, mine.stderr) == (theirs.returncode, theirs.stdout, theirs.stderr)
        running.setParam("/test", "/run_id", "given")
    place.uri = f"http://localhost:{free_port()}"
    theirs, mine = place.tool("roslaunch-logs"), place.tool(*OURS, "--logs")
    assert (mine.returncode, mine.stdout, mine.stderr) == (theirs.returncode, theirs.stdout, theirs.stderr)


@WHO
def test_a_core_file_of_ones_own_x94(place: Place, who: str, monkeypatch: pytest.MonkeyPatch) -> None:
    etc = place.folder / "etc"
    etc.mkdir()
    rosout = '<node pkg="rosout" type="rosout" name="rosout" respawn="true"/>'
    more = NODE.format("stay", "more", "")
    params = '<param name="rosdistro" command="rosversion -d"/><param name="extra" value="7"/>'
    (etc / "roscore.xml").write_text(f'<launch><group ns="/">{params}{rosout}{more}</group></launch>')
    monkeypatch.setenv("ROS_ETC_DIR", str(etc))
    (place.folder / "fail.launch").write_text(f"<launch>{NODE.format('fail', 'a', '')}</launch>")
    done = place.run(who, "fail.launch", ready=lambda: place.has_said("stay")() and place.has_said("fail")())
    assert done.code == 0
    wanted = [" * /extra: 7", "process[rosout-1]: started", "process[stay_more-2]: started"]
    wanted.append("started core service [/stay_more]")
    if who == "ours" or "process[fail_a-3]" in done.out:  # else Ctrl-C ended stock's before it said so
        wanted.append("process[fail_a-3]: started")
    # Not by lines: stock's threads print a text and its line break separately, so that lines can run together.
    places = [done.out.find(text) for text in wanted]
    assert -1 not in places and places == sorted(places), done.out
    assert "stay_more (" not in done.out and "fail_a (telling/say)" in done.out
    assert (
        "stay_more" not in place.tool(*(OURS if who == "ours" else ["roslaunch"]), "--nodes", "../fail.launch").stdout
    )
