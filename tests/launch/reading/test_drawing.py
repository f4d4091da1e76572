"""A plan as a tree and as a graph."""

from __future__ import annotations

from pyros1.launch.plan import ExitPolicy, IncludePlan, NodePlan, Plan
from pyros1.launch.reading.conditions import Condition
from pyros1.launch.reading.drawing import dot_text, tree_text

PLAN = Plan(
    nodes=[
        NodePlan("p", "t", "a", file="m", line=2, exit_policy=ExitPolicy(required=True)),
        NodePlan("p", "t", "b", "/g/", file="i", line=1, machine="arm"),
        NodePlan("p", "t", "c", file="m", line=9, wait_for=[Condition("node", "/a"), Condition("topic", "/x")]),
    ],
    files=["m", "i"],
    includes=[IncludePlan("m", 5, "i")],
)


def test_tree() -> None:
    assert tree_text(PLAN).splitlines() == [
        "m",
        "├── /a (p/t) [required]",
        "├── i",
        "│   └── /g/b (p/t) [on arm]",
        "└── /c (p/t) [after node:/a topic:/x]",
    ]
    assert tree_text(Plan()) == ""


def test_dot() -> None:
    text = dot_text(PLAN)
    assert text.startswith("digraph launch {\n") and text.endswith("\n}")
    for line in (
        '  "m" [shape=box, label="m"];',
        '  "/a" [label="/a\\np/t"];',
        '    label="arm";',
        '    "/g/b" [label="/g/b\\np/t"];',
        '  "m" -> "i";',
        '  "i" -> "/g/b";',
        '  "/c" -> "/a" [style=dashed];',
        '  "/c" -> "topic:/x" [style=dashed];',
    ):
        assert line in text.splitlines(), text


def test_a_file_is_drawn_once() -> None:
    plan = Plan(files=["m", "i", "i"], includes=[IncludePlan("m", 1, "i"), IncludePlan("m", 2, "i")])
    assert tree_text(plan).splitlines() == ["m", "├── i", "└── i (see above)"]
