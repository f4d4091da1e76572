# ruff: noqa: E501 - long expectations
"""SUMMARY and queries (X82, L164, L173)."""

from __future__ import annotations

from pyros1.launch.plan import ArgPlan, MachinePlan, NodePlan, Plan
from pyros1.launch.reading.report import dump_params, node_args, ros_args, summary


def test_summary_x82() -> None:
    plan = Plan(
        nodes=[NodePlan("p", "t", "b"), NodePlan("p", "t", "a"), NodePlan("q", "u", "c", "/g/")],
        params={"/s": "x" * 30, "/b": b"bin\n", "/w": "a\nb", "/l": [1, {"a": 2}]},
        clear_params=["/g/"],
    )
    assert summary(plan, {"/rosdistro": "noetic\n"}) == (
        "\nSUMMARY\n========\n\nCLEAR PARAMETERS\n * /g/\n\nPARAMETERS\n * /b: bin\n * /l: [1, {'a': 2}]\n * /rosdistro: noetic\n"
        f" * /s: {'x' * 17}...\n * /w: <...>\n\nNODES\n  /\n    a (p/t)\n    b (p/t)\n  /g/\n    c (q/u)\n"
    )


def test_machines_are_listed_if_a_node_runs_on_another_one() -> None:
    machines = {"b": MachinePlan("b", "192.0.2.1"), "a": MachinePlan("a", "localhost")}
    elsewhere, here = NodePlan("p", "t", "far", machine="b"), NodePlan("p", "t", "near", machine="a")
    assert "\n\nMACHINES\n * a\n * b\n\nNODES\n" in summary(Plan(nodes=[elsewhere, here], machines=machines))
    assert "MACHINES" not in summary(Plan(nodes=[here], machines=machines))
    assert "PARAMETERS" not in summary(Plan())


def test_dump_params() -> None:
    assert dump_params(Plan(params={"/b": [1], "/a": "yes"})) == "/a: 'yes'\n/b:\n- 1\n"


def test_ros_args_l173() -> None:
    args = {"req": ArgPlan("req", None, "needed"), "opt": ArgPlan("opt", "5", None)}
    assert (
        ros_args(Plan(args=args))
        == 'Required Arguments:\n  req: needed\nOptional Arguments:\n  opt (default "5"): undocumented'
    )
    assert ros_args(Plan()) == "No arguments."


def test_node_args() -> None:
    node = NodePlan("p", "t", "n", "/grp/", env={"FOO": "bar"})
    assert node_args(node, ["/p", "x"], {"ROS_MASTER_URI": "http://m:1"}) == 'ROS_NAMESPACE="/grp" FOO="bar" /p x'
    assert node_args(node, ["/p"], {}).startswith('ROS_MASTER_URI="http://localhost:11311/" ROS_NAMESPACE=')
    own = {"ROS_MASTER_URI": "http://m:1", "FOO": "own", "ROS_NAMESPACE": "/up"}
    assert node_args(node, ["/p"], own) == 'FOO="bar" ROS_NAMESPACE="/grp" /p', "this process's variables come first"
