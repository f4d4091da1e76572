"""All problems of a set of launch files at once, and what is missing on this machine.

Feature: `pyros1 launch --check` finds problems before anything starts -- with suggestions for misspelt names; also
    scripts that the system cannot execute, and syntax errors and missing imports in Python nodes
"""

from __future__ import annotations

import datetime
import os
from pathlib import Path

import pytest

from pyros1.finding.packages import OWN_PACKAGES
from pyros1.ground.errors import LaunchError, PackageNotFoundError
from pyros1.launch.plan import MachinePlan, NodePlan, Plan
from pyros1.launch.reading.conditions import Condition
from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.on_death import OnDeath
from pyros1.launch.reading.resources import Resources
from pyros1.launch.running.check import check_machines, plan_errors, python_node_errors

_Paths = list[Path]
_Names = list[str]


class Packages:
    def find(self, name: str) -> Path:
        if name != "robot":
            raise PackageNotFoundError(f"package [{name}] not found")
        return Path("/ws/robot")

    def list(self) -> _Names:
        return ["robot"]

    def find_resource(self, package: str, filename: str) -> _Paths:
        return []

    def executables(self, package: str) -> _Names:
        self.find(package)
        return ["run", "run_away"]

    def find_executable(self, package: str, name: str) -> _Paths:
        return [self.find(package) / name] if name == "run" else []


FILES = {
    "main.launch": """<launch>
  <arg name="speed" default="1"/>
  <param name="a" value="$(arg spede)"/>
  <param name="b" value="$(find robt)"/>
  <include file="part.launch"><arg name="spede" value="2"/></include>
  <nod/>
</launch>""",
    "part.launch": """<launch>
  <arg name="speed" default="1"/>
  <node pkg="robot" type="run"/>
  <param name="c" value="$(finde robot)"/>
</launch>""",
}


def test_every_problem_is_found_with_its_place_and_a_hint() -> None:
    problems: list[LaunchError] = []
    resources = Resources(Packages(), {}, read_bytes=lambda name: FILES[name].encode())
    plan = load_plan(["main.launch"], {"sped": "3"}, resources, problems=problems)
    texts = [str(problem) for problem in problems]
    assert len(texts) == 5
    assert texts[0].startswith("main.launch:3: ") and texts[0].endswith("(did you mean 'speed'?)")
    assert texts[1].startswith("main.launch:4: ") and texts[1].endswith("(did you mean 'robot'?)")
    assert texts[2].startswith("part.launch:3: ") and texts[2].endswith("\n  included at main.launch:5")
    assert texts[3].startswith("part.launch:4: ") and "(did you mean 'find'?)" in texts[3]
    assert texts[4] == "main.launch:5: unused args [spede] for include of [part.launch] (did you mean 'speed'?)"
    assert plan.warnings == [
        "[main.launch:6] unrecognized tag nod (did you mean 'node'?)",
        "unused arg 'sped' (did you mean 'speed'?)",
    ]


def test_the_first_problem_is_raised_with_the_chain_of_includes() -> None:
    files = {
        "a": '<launch>\n<include file="b"/></launch>',
        "b": '<launch>\n\n<include file="c"/></launch>',
        "c": "<launch><env/></launch>",
    }
    resources = Resources(Packages(), {}, read_bytes=lambda name: files[name].encode())
    with pytest.raises(LaunchError, match=r"^c:1: .*\n  included at b:3\n  included at a:2$"):
        load_plan(["a"], {}, resources)


def test_plan_errors() -> None:
    nodes = [
        NodePlan("robot", "run", "fine"),
        NodePlan("robt", "run", "no_package", file="f", line=1),
        NodePlan("robot", "walk", "no_type", file="f", line=2),
        NodePlan("robot", "run", "no_machine", machine="arrm", file="f", line=3),
        NodePlan("robot", "runaway", "misspelt", file="f", line=4),
        NodePlan("nope", "nope", "elsewhere", machine="arm"),
        NodePlan("nope", "nope", "nowhere", machine="leg", file="f", line=5),
    ]
    plan = Plan(nodes=nodes, machines={"arm": MachinePlan("arm", "192.0.2.1"), "leg": MachinePlan("leg", "")})
    texts = [str(error) for error in plan_errors(plan, Packages(), {"PATH": os.defpath})]
    assert texts[0] == "f:3: node [/no_machine]: unknown machine [arrm] (did you mean 'arm'?)"
    assert texts.pop(1) == "f:5: node [/nowhere]: machine [leg] has no address: 'address' is empty in its <machine> tag"
    assert texts[1] == "f:1: node [/no_package]: package [robt] not found (did you mean 'robot'?)"
    assert texts[2].startswith("f:2: node [/no_type]: Cannot locate node of type [walk] in package [robot]")
    assert "did you mean" not in texts[2]
    assert texts[3].startswith("f:4: node [/misspelt]: ") and texts[3].endswith("(did you mean 'run_away'?)")
    assert len(texts) == 4
    with pytest.raises(LaunchError, match="unknown machine"):
        check_machines(plan)
    check_machines(Plan())


def test_parameters_that_cannot_be_sent() -> None:
    plan = Plan(params={"/calibrated": datetime.date(2014, 5, 1), "/gain": 2.0, "/none": [None]})
    assert [str(error) for error in plan_errors(plan, Packages(), {})] == [
        "parameter /calibrated: a date cannot be sent over XML-RPC; put it in quotes to make it a string",
        "parameter /none: None (null) cannot be sent over XML-RPC; put it in quotes to make it a string",
    ]


def test_prefixes_that_are_not_there() -> None:
    plan = Plan(nodes=[NodePlan("robot", "run", "n", prefix=["nice_try", "-n", "5"], file="f", line=1)])
    texts = [str(error) for error in plan_errors(plan, Packages(), {"PATH": os.defpath})]
    assert texts == ["f:1: node [/n]: launch-prefix: program [nice_try] not found on the PATH"]


def test_scripts_that_cannot_be_started(tmp_path: Path) -> None:
    class Scripts(Packages):
        def find_executable(self, package: str, name: str) -> _Paths:
            return [tmp_path / name]

    (tmp_path / "bare").write_text("import pyros1\n")
    plan = Plan(
        nodes=[
            NodePlan("robot", "bare", "n", file="f", line=1),
            NodePlan("robot", "bare", "m", prefix=["sh"], file="f", line=2),
        ]
    )
    (text,) = map(str, plan_errors(plan, Scripts(), {"PATH": os.defpath}))
    assert text.startswith(f"f:1: node [/n]: cannot run {tmp_path}/bare: its first line does not name an interpreter")


def test_nodes_that_wait_for_themselves() -> None:
    def node(name: str, *needs: str) -> NodePlan:
        return NodePlan("robot", "run", name, wait_for=[Condition("node", need) for need in needs], file="f", line=1)

    plan = Plan(
        nodes=[node("a", "/b"), node("b", "/c", "/d"), node("c", "/a"), node("d"), node("e", "/e"), node("f", "/a")]
    )
    texts = [str(error).removeprefix("f:1: ") for error in plan_errors(plan, Packages(), {})]
    assert texts == [
        f"node [/{name}]: it can never start: it waits for itself ({chain})"
        for name, chain in (
            ("a", "/a -> /b -> /c -> /a"),
            ("b", "/b -> /c -> /a -> /b"),
            ("c", "/c -> /a -> /b -> /c"),
            ("e", "/e -> /e"),
        )
    ]


def test_a_file_that_includes_itself_is_named_once() -> None:
    resources = Resources(Packages(), {}, read_bytes=lambda name: b'<launch><include file="a"/></launch>')
    with pytest.raises(LaunchError) as caught:
        load_plan(["a"], {}, resources)
    assert str(caught.value).count("included at a:1") == 1 and str(caught.value).endswith("(repeatedly)")


def test_what_is_done_on_death_must_be_possible() -> None:
    deaths = {
        "a": OnDeath("pub", ("/t", "std_msgs/Float64", "0.0")),
        "b": OnDeath("pub", ("/t", "std_msgs/Float", "0.0")),
        "c": OnDeath("pub", ("/t", "std_msgs/Float64", "fast")),
        "d": OnDeath("run", ("robot", "run")),
        "e": OnDeath("run", ("robot", "brake")),
    }
    plan = Plan(
        nodes=[NodePlan("robot", "run", name, on_death=death, prefix=["true"]) for name, death in deaths.items()]
    )
    found = [str(error) for error in plan_errors(plan, Packages(), {"PATH": os.defpath})]
    assert [text.partition("]")[0] for text in found if "/d_on_death" not in text] == [
        "node [/b",
        "node [/c",
        "node [/e_on_death",
    ]
    assert "on-death 'pub /t std_msgs/Float 0.0': " in found[0] and "Cannot locate node of type [brake]" in found[-1]


def test_programs_in_python_that_cannot_run_are_named_with_their_nodes(tmp_path: Path) -> None:
    """Those on other machines, for other interpreters and in unknown packages are not looked at."""

    class Programs(Packages):
        def find_executable(self, package: str, name: str) -> _Paths:
            return [self.find(package) and tmp_path / name]

    (tmp_path / "wrong").write_text("#!/usr/bin/env python3\na b\n")
    nodes = [
        NodePlan("robot", "wrong", "here", file="f", line=1),
        NodePlan("robot", "wrong", "far", machine="arm", file="f", line=2),
        NodePlan("robot", "wrong", "other", prefix=["/opt/bin/python3.9"], file="f", line=3),
        NodePlan("nothing", "wrong", "unknown", file="f", line=4),
    ]
    machines = {"arm": MachinePlan("arm", "192.0.2.1")}

    def said(*nodes: NodePlan) -> list[str]:
        return [str(error) for error in python_node_errors(Plan([*nodes], machines=machines), Programs(), {})]

    assert said(*nodes) == [f"f:1: node [/here]: it cannot run: {tmp_path}/wrong:2: invalid syntax"]
    assert said(*nodes[1:]) == []


@pytest.mark.parametrize(
    ("args", "problem"),
    [
        ("manager", ""),
        ("load --no-bond robot/Run manager", ""),
        ("standalone robot/RunAway", ""),
        ("standalone robot/Swim", "pyros1 has no node that replaces the nodelet robot/Swim: "),
        ("load camera/NodeletThrottleImage manager", ""),
        ("load camera/Driver manager", "no package camera for the nodelet camera/Driver: "),
        ("load", "too few arguments: load pkg/Type manager is expected"),
        ("--no-bond load camera/NodeletThrottleImage a:=b", "too few arguments: load pkg/Type manager is expected"),
        ("a:=b manager _x:=1", ""),
        ("lode robot/swim m", "the first argument must be manager, load, standalone or unload, not 'lode'"),
        ("", "the first argument must be manager, load, standalone or unload, but there is none"),
    ],
)
def test_nodelets_without_a_program_are_found(args: str, problem: str) -> None:
    class WithNodelets(Packages):
        def find_executable(self, package: str, name: str) -> _Paths:
            return [Path(OWN_PACKAGES) / "nodelet" / "scripts" / "nodelet"] if package == "nodelet" else []

    node = NodePlan("nodelet", "nodelet", "n", args=args.split(), file="a.launch", line=3)
    errors = [*plan_errors(Plan(nodes=[node]), WithNodelets(), {})]
    assert [str(error).partition("n]: ")[2][: len(problem)] for error in errors] == [problem] * bool(problem)


@pytest.mark.parametrize(
    ("package", "folder"), [("nodelet", "/opt/ros/noetic/lib"), ("joy", OWN_PACKAGES), ("other", "/opt/ros/noetic/lib")]
)
def test_only_the_arguments_of_the_own_nodelet_program_are_checked(package: str, folder: str) -> None:
    class WithPrograms(Packages):
        def find_executable(self, package: str, name: str) -> _Paths:
            return [Path(folder, package, "scripts", name)]

    node = NodePlan(package, "nodelet", "n", args=["lode", "robot/Swim"], file="a.launch", line=3)
    assert [*plan_errors(Plan(nodes=[node]), WithPrograms(), {})] == []
