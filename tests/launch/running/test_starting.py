"""launch.running.starting: from the plan of a node to the description of its process."""

from __future__ import annotations

import io
import os
import queue
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pyros1.finding.packages import PackageIndex
from pyros1.ground.errors import LaunchError
from pyros1.launch.plan import ExitPolicy, MachinePlan, NodePlan, Plan, TestPlan
from pyros1.launch.reading.conditions import Condition
from pyros1.launch.reading.on_death import OnDeath
from pyros1.launch.running.console import Console
from pyros1.launch.running.options import Options
from pyros1.launch.running.process_spec import ProcessSpec
from pyros1.launch.running.starting import RunInfo, Starter
from pyros1.master.server import Master
from pyros1.net.master_client import MasterClient

PACKAGE = """<package format="2"><name>robot</name><version>1.0.0</version><description>A node.</description>
<maintainer email="a@example.org">a</maintainer><license>BSD</license></package>"""
SETTINGS: dict[str, Any] = {
    "exit_policy": ExitPolicy(respawn=True, respawn_delay=7.5, required=True),
    "priority": 50,
}


DEADLINE = 20.0
machines: list[FakeMachine] = []


class Recorder:
    """Stands for a supervisor, and starts nothing."""

    def __init__(self) -> None:
        self.specs: list[ProcessSpec] = []
        self.kinds: list[object] = []
        self.refuses = False
        self.out, self.err = io.StringIO(), io.StringIO()
        self.num_expected = 0
        self.required_failed = False
        self.stopped: list[str] = []
        self.resumed: list[object] = []
        self.tasks: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()

    def call_soon(self, task: Callable[[], object]) -> None:
        self.tasks.put(task)

    def do_next(self) -> None:
        """Do what the thread of a launch would do."""
        self.tasks.get(timeout=DEADLINE)()

    def stop(self, reason: str) -> None:
        self.stopped.append(reason)

    def resume(self, processes: list[object]) -> None:
        self.resumed += processes

    def start(self, spec: ProcessSpec, kind: object = None) -> bool:
        self.specs.append(spec)
        self.kinds.append(kind)
        return not self.refuses

    def find(self, label: str) -> str:
        return f"the process of {label}"


class FakeMachine:
    """A machine to which every connection succeeds."""

    def __init__(self, plan: MachinePlan, *arguments: Any) -> None:
        self.closed = False
        self.plan = plan
        *_, self.on_reconnected = arguments
        machines.append(self)

    def connect(self) -> None: ...

    def close(self) -> None:
        self.closed = True

    def wait_ready(self) -> None: ...

    def make_process_factory(self, node: NodePlan, run_id: str) -> str:
        return f"{node.name} of {run_id}"


@pytest.fixture
def make_starter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Starter]:
    package = tmp_path / "robot"
    package.mkdir()
    (package / "package.xml").write_text(PACKAGE)
    (package / "drive").write_text("#!/bin/sh\n")
    (package / "drive").chmod(0o755)
    environ = {**os.environ, "ROS_PACKAGE_PATH": str(package), "ROS_HOME": str(tmp_path / "home")}

    monkeypatch.setattr("pyros1.launch.remote.over_ssh.make_machine", FakeMachine)
    machines.clear()

    def make(master_uri: str = "http://me:1/", **options: Any) -> Starter:
        run = RunInfo(master_uri, "run-id", tmp_path / "logs", tmp_path / "logs" / "launch.log")
        machines = {"far": MachinePlan("far", "far.invalid"), "here": MachinePlan("here", "localhost")}
        recorder: Any = Recorder()
        console = Console(recorder.out, recorder.err)
        packages = PackageIndex(environ)
        plan = Plan(nodes=[NodePlan("robot", "drive", "first", machine="far")], machines=machines)
        starter = Starter(plan, Options(**options), packages, environ, console, recorder, run)
        starter.connect()
        return starter

    return make


@pytest.mark.parametrize("machine", [None, "here", "far"])
def test_a_node_is_started_as_its_plan_says(make_starter: Callable[..., Starter], machine: str | None) -> None:
    starter = make_starter()
    starter.start(
        NodePlan("robot", "drive", "wheels", "/left/", ["fast"], machine=machine, output="screen", **SETTINGS)
    )
    recorder: Any = starter.supervisor
    (spec,) = recorder.specs
    assert (spec.label, spec.node, spec.package) == ("left/wheels-1", "/left/wheels", "robot")
    assert (spec.exit_policy.respawn, spec.exit_policy.respawn_delay, spec.exit_policy.required, spec.to_screen) == (
        True,
        7.5,
        True,
        True,
    )
    assert spec.priority == 50
    assert recorder.kinds == ["wheels of run-id" if machine == "far" else None]
    starter.start(NodePlan("robot", "drive", "arm", machine=machine))
    spec = recorder.specs[1]
    assert (spec.label, spec.exit_policy, spec.priority) == ("arm-2", ExitPolicy(), 0)
    assert (spec.to_screen, spec.on_death_spec, spec.ends_launch) == (False, None, False)


@pytest.mark.parametrize("machine", [None, "far"])
def test_options_of_the_launch_hold_for_all_nodes(make_starter: Callable[..., Starter], machine: str | None) -> None:
    starter = make_starter(screen=True, required=True)
    starter.start(NodePlan("robot", "drive", "wheels", machine=machine))
    starter.options.screen = False
    starter.start(NodePlan("robot", "drive", "arm", machine=machine, output="screen"))
    recorder: Any = starter.supervisor
    assert [(spec.exit_policy.required, spec.to_screen) for spec in recorder.specs] == [(True, True), (True, False)]


def test_the_process_on_this_machine(make_starter: Callable[..., Starter], tmp_path: Path) -> None:
    starter = make_starter()
    spec = starter.make_spec(NodePlan("robot", "drive", "wheels", "/left/", ["fast"]), "left/wheels-1")
    drive = tmp_path / "robot" / "drive"
    log = tmp_path / "logs" / "left-wheels-1"
    assert spec.words == [str(drive), "fast", "__name:=wheels", f"__log:={log}.log"]
    assert (spec.log_base, spec.cwd) == (str(log), str(tmp_path / "home"))
    assert spec.env["ROS_MASTER_URI"] == "http://me:1/" and spec.env["ROS_NAMESPACE"] == "/left"
    assert spec.env["ROS_LOG_FILENAME"] == str(tmp_path / "logs" / "launch.log")
    assert starter.make_spec(NodePlan("robot", "drive", "wheels", cwd="node"), "w").cwd == str(drive.parent)


def test_what_runs_when_a_node_has_ended(make_starter: Callable[..., Starter]) -> None:
    starter = make_starter()
    recorder: Any = starter.supervisor
    run = OnDeath("run", ("robot", "drive", "home"))
    publish = OnDeath("pub", ("/stop", "std_msgs/Empty"))
    for required in (True, False):
        for on_death, words in ((run, ["home", "__name:=wheels_on_death"]), (publish, ["/stop", "std_msgs/Empty"])):
            starter.start(
                NodePlan(
                    "robot", "drive", "wheels", "/left/", exit_policy=ExitPolicy(required=required), on_death=on_death
                )
            )
            after = recorder.specs[-1].on_death_spec
            assert (after.label, after.node) == (f"{recorder.specs[-1].label}-on-death", "/left/wheels_on_death")
            assert (after.exit_policy.required, after.ends_launch, after.exit_policy.respawn) == (
                False,
                required,
                False,
            )
            assert [word for word in words if word not in after.words] == []
            assert after.env["ROS_MASTER_URI"] == "http://me:1/"


def test_one_more_node(make_starter: Callable[..., Starter]) -> None:
    starter = make_starter()
    recorder: Any = starter.supervisor
    assert str(starter.start_one(NodePlan("robot", "drive", "wheels"))) == "the process of wheels-1"
    with pytest.raises(LaunchError, match=r"node \[/arm\] runs on another machine: put it into a launch file"):
        starter.start_one(NodePlan("robot", "drive", "arm", machine="far"))
    recorder.refuses = True
    with pytest.raises(LaunchError, match=r"node \[/arm\] cannot be started"):
        starter.start_one(NodePlan("robot", "drive", "arm"))


def test_a_node_that_cannot_be_found(make_starter: Callable[..., Starter]) -> None:
    starter = make_starter()
    starter.start(NodePlan("robot", "dive", "wheels", file="a.launch", line=3))
    recorder: Any = starter.supervisor
    assert not recorder.specs
    text = recorder.err.getvalue()
    assert "cannot launch node of type [robot/dive]" in text and "at a.launch:3" in text and "drive" in text
    starter.start(NodePlan("robot", "dive", "wheels", file="program.py"))
    assert recorder.err.getvalue().endswith("at program.py\n"), "a program does not say in which line"


def test_a_node_waits_for_what_it_needs(make_starter: Callable[..., Starter], master: Master) -> None:
    starter = make_starter(master.uri)
    recorder: Any = starter.supervisor
    try:
        starter.start(NodePlan("robot", "drive", "wheels", wait_for=[Condition("param", "/ready")]))
        assert "[wheels-1] waiting for param:/ready\n" in recorder.out.getvalue()
        assert (recorder.specs, recorder.num_expected) == ([], 1)
        client = MasterClient("/test", master.uri)
        client.set_param("/ready", True)
        client.close()
        recorder.do_next()
    finally:
        starter.cancel_waiting()
    assert ([spec.label for spec in recorder.specs], recorder.num_expected) == (["wheels-1"], 0)
    starter.cancel_waiting()


@pytest.mark.parametrize("required", [False, True])
def test_a_node_that_has_waited_too_long(make_starter: Callable[..., Starter], master: Master, required: bool) -> None:
    starter = make_starter(master.uri, required=required)
    recorder: Any = starter.supervisor
    wait_for = [Condition("param", "/ready"), Condition("node", "/other")]
    try:
        starter.start(
            NodePlan("robot", "drive", "wheels", wait_for=wait_for, wait_timeout=0.01, file="a.launch", line=3)
        )
        recorder.do_next()
    finally:
        starter.cancel_waiting()
    said = recorder.err.getvalue()
    assert "[wheels-1] is not started: param:/ready, node:/other did not appear within 0.01 s (wait-for at" in said
    assert "(wait-for at a.launch:3)" in said
    assert (recorder.specs, recorder.num_expected, recorder.required_failed) == ([], 0, required)
    assert recorder.stopped == (["required node /wheels could not be started"] if required else [])


def test_a_machine_is_connected_until_the_end_and_its_nodes_resume(make_starter: Callable[..., Starter]) -> None:
    starter = make_starter()
    (machine,) = machines
    assert (machine.plan.name, machine.closed) == ("far", False)
    machine.on_reconnected(["a process"])
    recorder: Any = starter.supervisor
    assert recorder.resumed == []  # not in the thread of the connection
    recorder.do_next()
    assert recorder.resumed == ["a process"]
    starter.close()
    assert machine.closed


def test_a_test_ends_the_launch(make_starter: Callable[..., Starter]) -> None:
    starter = make_starter()
    recorder: Any = starter.supervisor
    starter.start_test(TestPlan("robot", "drive", "it", "/left/", test_name="its"))
    assert [(spec.label, spec.ends_launch) for spec in recorder.specs] == [("left/it-1", True)]
    recorder.refuses = True
    with pytest.raises(LaunchError, match=r"test \[its\] cannot be started"):
        starter.start_test(TestPlan("robot", "drive", "it", test_name="its"))


def test_a_folder_of_nodes_that_cannot_be_made_is_named(make_starter: Callable[..., Starter], tmp_path: Path) -> None:
    (tmp_path / "home").touch()
    with pytest.raises(
        LaunchError, match=r"cannot create the folder .*/home, where nodes run: File exists; set ROS_HOME"
    ):
        make_starter().make_spec(NodePlan("robot", "drive", "wheels"), "wheels-1")


def test_an_answer_that_cannot_be_given_is_said_before_the_node_runs(make_starter: Callable[..., Starter]) -> None:
    starter = make_starter()
    recorder: Any = starter.supervisor
    starter.start(NodePlan("robot", "drive", "wheels", on_death=OnDeath("run", ("robot", "dive"))))
    starter.start(NodePlan("robot", "drive", "arm", on_death=OnDeath("pub", ("/stop", "std_msgs/Emptyy"))))
    assert not recorder.specs
    first, second = recorder.err.getvalue().split("cannot launch node of type [robot/drive]: ")[1:]
    assert first.startswith("on-death 'run robot dive': Cannot locate node of type [dive] in package [robot]")
    assert "std_msgs/Emptyy" in second


def test_the_environment_is_read_once_while_many_nodes_are_started(make_starter: Callable[..., Starter]) -> None:
    starter = make_starter()
    environ: Any = starter.environ
    with starter.environment_copied():
        environ["LATER"] = "yes"
        assert "LATER" not in starter.environ
    assert starter.environ is environ
