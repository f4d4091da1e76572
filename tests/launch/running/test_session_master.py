"""launch.running.session: which master a launch uses or starts, and what it tells of that."""

from __future__ import annotations

import io
import os
import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.finding.packages import PackageIndex
from pyros1.ground.errors import LaunchError
from pyros1.launch.plan import NodePlan, Plan
from pyros1.launch.running.console import Console
from pyros1.launch.running.core_journal import CoreJournal
from pyros1.launch.running.options import Options
from pyros1.launch.running.session import Session
from pyros1.master.server import Master
from pyros1.net.hosts import parse_uri
from pyros1.net.master_client import MasterClient

DEADLINE = 20.0
PACKAGE = "<package format='2'><name>robot</name></package>"


class Said(io.StringIO):
    """What a launch says, and what to do when it says something."""

    def __init__(self) -> None:
        super().__init__()
        self.reactions: dict[str, Callable[[], object]] = {}

    def write(self, text: str) -> int:
        for part, react in self.reactions.items():
            if part in text:
                react()
        return super().write(text)


class Launch:
    """A session that ends when all has been started."""

    def __init__(self, plan: Plan, environ: dict[str, str], **options: Any) -> None:
        self.out, self.err = Said(), Said()
        self.environ = environ
        console = Console(self.out, self.err, title=False)
        options = {"show_summary": False, "sigint_timeout": 0.1, **options}
        self.session = Session(plan, Options(**options), PackageIndex(environ), environ, console, self.ended)
        self.while_up: Callable[[], object] = lambda: None

    def ended(self) -> None:
        self.while_up()
        self.session.stop("enough")

    def run(self) -> None:
        self.session.run()


@pytest.fixture
def make(tmp_path: Path, free_port: int) -> Callable[..., Launch]:
    """Return a function that makes a launch; without other settings its master is one that does not run."""
    (tmp_path / "robot").mkdir()
    (tmp_path / "robot" / "package.xml").write_text(PACKAGE)
    (tmp_path / "robot" / "drive").write_text("#!/bin/sh\nexec sleep 100\n")
    (tmp_path / "robot" / "drive").chmod(0o755)
    common = {
        "PATH": os.environ["PATH"],
        "ROS_HOME": str(tmp_path / "home"),
        "ROS_HOSTNAME": "localhost",
        "ROS_MASTER_URI": f"http://localhost:{free_port}/",
        "ROS_PACKAGE_PATH": str(tmp_path / "robot"),
    }

    def make(plan: Plan | None = None, environ: dict[str, str] | None = None, **options: Any) -> Launch:
        return Launch(plan or Plan(), {**common, **(environ or {})}, **options)

    return make


@pytest.fixture
def silent() -> Iterator[int]:
    """The port of a program that accepts connections and answers nothing."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield server.getsockname()[1]


def test_a_master_that_does_not_answer_is_not_replaced(
    make: Callable[..., Launch], silent: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.launch.running.session.PING_TIMEOUT", 0.05)
    uri = f"http://127.0.0.1:{silent}/"
    with pytest.raises(LaunchError, match=r"the ROS master at \[.*\] does not answer within 0\.05 s: is it suspended"):
        make(environ={"ROS_MASTER_URI": uri}).run()


def test_no_master_is_started_for_another_machine(make: Callable[..., Launch], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.launch.running.session.is_local", lambda host: False)
    with pytest.raises(LaunchError, match="it is on another machine, so it is not started here"):
        make().run()


def test_a_master_that_was_named_by_an_unknown_host_says_what_to_do(make: Callable[..., Launch]) -> None:
    with pytest.raises(LaunchError, match=r"add a line 'ADDRESS nohost\.invalid' to /etc/hosts"):
        make(environ={"ROS_MASTER_URI": "http://nohost.invalid:11311"}).run()


def test_a_second_core_is_refused(make: Callable[..., Launch], master: Master) -> None:
    with pytest.raises(LaunchError, match="roscore cannot run as another roscore/master is already running"):
        make(environ={"ROS_MASTER_URI": master.uri}, core=True).run()


def test_a_launch_can_wait_for_a_master(make: Callable[..., Launch], free_port: int) -> None:
    launch = make(wait=True)
    late = Master(port=free_port, bind_host="127.0.0.1")
    launch.out.reactions["will wait for it to start"] = late.start
    try:
        launch.run()
    finally:
        late.stop()
    said = launch.out.getvalue()
    assert said.index("will wait for it to start") < said.index("master has started, initiating launch")
    assert "auto-starting new master" not in said


def test_waiting_for_a_master_can_be_interrupted(make: Callable[..., Launch]) -> None:
    launch = make(wait=True)
    launch.session.stop("Ctrl-C")
    with pytest.raises(LaunchError, match="interrupted while waiting for the master"):
        launch.run()


@pytest.mark.parametrize(
    ("uri", "said"),
    [
        ("nonsense", "WARNING: ROS_MASTER_URI is not usable: "),
        ("http://192.0.2.1:11311", "ROS_MASTER_URI [http://192.0.2.1:11311] host is not set to this machine"),
        ("http://localhost:1", "ROS_MASTER_URI port [1] does not match this roscore [{}]"),
        ("", None),
    ],
)
def test_a_core_that_nodes_would_not_find_is_warned_of(
    make: Callable[..., Launch], free_port: int, uri: str, said: str | None
) -> None:
    launch = make(environ={"ROS_MASTER_URI": uri}, core=True, port=free_port)
    launch.run()
    assert (said.format(free_port) in launch.err.getvalue()) if said else not launch.err.getvalue()
    assert "ros_comm version 1.16.0" in launch.out.getvalue()


def test_a_master_on_one_address_gets_the_usual_port_there(
    make: Callable[..., Launch], free_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.launch.running.session.DEFAULT_MASTER_URI", f"http://localhost:{free_port}")
    launch = make(environ={"ROS_MASTER_URI": "", "ROS_HOSTNAME": "127.0.0.1", "PYROS1_BIND": "127.0.0.1"})
    found: list[str] = []

    def ask() -> None:
        client = MasterClient("/test", f"http://127.0.0.1:{free_port}/")
        found.append(client.lookup_node("/rosout"))
        client.close()

    launch.while_up = ask
    launch.run()
    assert f"\nROS_MASTER_URI=http://127.0.0.1:{free_port}/\n" in launch.out.getvalue()
    assert found, "the rosout node runs there, too"


def test_a_host_name_that_looks_wrong_is_warned_of(make: Callable[..., Launch], master: Master) -> None:
    launch = make(environ={"ROS_MASTER_URI": master.uri, "ROS_HOSTNAME": "http://localhost"})
    launch.run()
    assert "WARNING: invalid ROS_HOSTNAME (protocol should not be included)" in launch.err.getvalue()


def test_the_nodes_of_the_core_file_run_with_the_core(make: Callable[..., Launch], tmp_path: Path) -> None:
    """With stock's file rosout is ours; here it is not wanted at all."""
    (tmp_path / "roscore.xml").write_text(
        '<launch><param name="p" value="5"/><node pkg="robot" type="drive" name="extra"/></launch>'
    )
    launch = make(environ={"ROS_ETC_DIR": str(tmp_path)})
    found: list[Any] = []

    def ask() -> None:
        client = MasterClient("/test", launch.environ["ROS_MASTER_URI"])
        found.append(client.get_param("/p"))
        client.close()

    launch.while_up = ask
    launch.run()
    assert found == [5]
    said = launch.out.getvalue()
    assert "started core service [/extra]" in said and "[extra-1] killing on exit" in said and "rosout" not in said


def test_a_port_that_is_in_use_is_said_and_the_journal_left_to_the_next(
    make: Callable[..., Launch], free_port: int
) -> None:
    options: dict[str, Any] = {"port": free_port, "journal": True, "core": True}
    with socket.socket() as taken:  # but nobody listens there
        taken.bind(("", free_port))
        with pytest.raises(LaunchError, match=r"cannot start a master at .*: the port is in use"):
            make(**options).run()
    launch = make(**options)
    launch.run()
    assert "has no journal" not in launch.err.getvalue()


def test_a_launch_leaves_the_journal_of_a_running_master_alone(
    make: Callable[..., Launch], master: Master, tmp_path: Path
) -> None:
    environ = {"ROS_HOME": str(tmp_path / "home")}
    core = CoreJournal(environ, parse_uri(master.uri)[1], Console(io.StringIO(), io.StringIO(), title=False))
    assert core.journal is not None
    core.journal.rewrite([("setParam", ["/", "/x", 1])])
    core.release()
    folder = tmp_path / "home" / "pyros1"
    before = sorted(folder.iterdir())
    launch = make(environ={"ROS_MASTER_URI": master.uri})
    launch.run()
    assert before and sorted(folder.iterdir()) == before
    assert "journal" not in launch.err.getvalue()


def test_a_launch_that_was_stopped_starts_no_more_nodes(make: Callable[..., Launch], master: Master) -> None:
    plan = Plan(nodes=[NodePlan("robot", "drive", name) for name in ("first", "second")])
    launch = make(plan, {"ROS_MASTER_URI": master.uri})
    start = launch.session.supervisor.start

    def start_and_stop(*arguments: Any) -> bool:
        launch.session.stop("Ctrl-C")
        return start(*arguments)

    launch.session.supervisor.start = start_and_stop  # type: ignore[method-assign]
    launch.run()
    assert "process[first-1]: started" in launch.out.getvalue() and "second-2" not in launch.out.getvalue()


def test_nodes_end_with_their_launcher(make: Callable[..., Launch], master: Master, opened: list[Any]) -> None:
    """Also if it is killed: then the system closes its end of the pipe to the watchdog."""
    launch = make(Plan(nodes=[NodePlan("robot", "drive", "wheels")]), {"ROS_MASTER_URI": master.uri})

    def close_pipe() -> None:
        next(process for process in opened if "watchdog" in str(process.args)).stdin.close()

    launch.session.on_started = close_pipe
    launch.run()
    assert "[wheels-1] process has died" in launch.err.getvalue()


def test_a_node_cannot_be_added_to_a_launch_that_does_not_run(make: Callable[..., Launch]) -> None:
    launch = make()
    with pytest.raises(LaunchError, match="the launch is not running"):
        launch.session.launch(NodePlan("robot", "drive", "late"))


def test_the_run_id_must_be_that_of_the_master(make: Callable[..., Launch], master: Master, tmp_path: Path) -> None:
    client = MasterClient("/test", master.uri)
    client.set_param("/run_id", "theirs")
    client.close()
    with pytest.raises(LaunchError, match="does not match declared run_id: theirs vs mine"):
        make(environ={"ROS_MASTER_URI": master.uri}, run_id="mine").run()
    make(environ={"ROS_MASTER_URI": master.uri}).run()
    assert (tmp_path / "home" / "log" / "theirs").is_dir()


def test_log_files_that_cannot_be_written_are_said(make: Callable[..., Launch], master: Master, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    environ = {"ROS_MASTER_URI": master.uri, "ROS_LOG_DIR": str(tmp_path / "file")}
    with pytest.raises(LaunchError, match=r"cannot write log files: .*\. Set ROS_LOG_DIR "):
        make(environ=environ).run()


def test_waiting_for_processes_can_be_cut_short(make: Callable[..., Launch], master: Master, tmp_path: Path) -> None:
    """The second Ctrl-C."""
    os.mkfifo(tmp_path / "up")
    script = f"trap '' INT TERM\necho up >{tmp_path / 'up'}\nwhile :; do sleep 100; done\n"
    (tmp_path / "robot" / "drive").write_text(f"#!/bin/sh\n{script}")
    plan = Plan(nodes=[NodePlan("robot", "drive", "stuck")])
    launch = make(plan, {"ROS_MASTER_URI": master.uri}, sigint_timeout=DEADLINE, sigterm_timeout=DEADLINE)
    launch.while_up = (tmp_path / "up").read_text
    for said in ("killing on exit", "escalating to SIGTERM"):
        launch.out.reactions[said] = launch.session.stop_waiting
    launch.run()
    assert "escalating to SIGKILL" in launch.out.getvalue()
