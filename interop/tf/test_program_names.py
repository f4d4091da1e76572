"""Names that tf's programs and robot_state_publisher register, with remappings: stock's beside ours."""

from __future__ import annotations

import contextlib
import re
import sys
from pathlib import Path

import pytest
from harness import SOURCE, STOCK_PYTHON, Master, until

MASTERS = ("ours",)
OWN_MASTER = True
ROBOT = """<robot name="r"><link name="base"/><link name="arm"/>
<joint name="j" type="continuous"><parent link="base"/><child link="arm"/></joint></robot>"""
REMAPPINGS = [
    "/tf:=/robot/tf",
    "tf_static:=not_absolute",
    "/ns/tf_old:=/robot/tf_old",
    "/tf_static:=/robot/tf_static",
    "joint_states:=joints",
    "tf2_buffer_server:=lookups",
    "/ns/lookups/goal:=goals",
    "tf_changes:=changes",
]
PROGRAMS = {
    "tf/static_transform_publisher": ("0 0 0 0 0 0 a b 100", 4),
    "tf2_ros/static_transform_publisher": ("0 0 0 0 0 0 a b", 4),
    "tf2_ros/buffer_server": ("", 10),
    "tf/tf_remap": ("", 5),
    "tf/tf_change_notifier": ("", 6),
    "robot_state_publisher/robot_state_publisher": ("", 6),
}
"""Program -> its arguments, and how many topics and services stock's has."""
OURS_ALONE = "/tf2_frames"
"""Our listeners describe their frames; stock's in C++ do so only if the program asks for it."""


@pytest.mark.parametrize("remappings", [[], REMAPPINGS], ids=["plain", "remapped"])
@pytest.mark.parametrize("program", PROGRAMS)
def test_programs_have_stocks_names(launcher: Master, program: str, remappings: list[str]) -> None:
    package, _, name = program.partition("/")
    stock = Path("/usr/lib") / package / name
    if not stock.exists():
        pytest.skip(f"{stock} is not installed")
    python = [STOCK_PYTHON] if stock.read_bytes().startswith(b"#!") else []
    ours = SOURCE / "pyros1" / "packages" / package / "scripts" / name
    launcher.call("setParam", "/robot_description", ROBOT)
    arguments, count = PROGRAMS[program]
    found = []
    for whose, command in (("stock", [*python, str(stock)]), ("ours", [sys.executable, str(ours)])):
        process = launcher.run([*command, *arguments.split(), *remappings, "__ns:=/ns"], python=whose, label=whose)
        until(lambda: len(registrations(launcher)) >= count, f"{whose} {program} is there")
        found.append(registrations(launcher))
        with contextlib.suppress(OSError):  # it may end before it answers
            # Stock's programs in Python may not end by a SIGINT that comes while they start.
            launcher.node(one_node(launcher), "shutdown", "the test has seen it")
        process.wait()
        until(lambda: not registrations(launcher), f"{whose} {program} has gone")
    assert found[1] == found[0]


def one_node(master: Master) -> str:
    """Return the name of a node in /ns."""
    nodes = {node for part in master.call("getSystemState")[2] for _, nodes in part for node in nodes}
    return next(node for node in nodes if node.startswith("/ns/"))


def registrations(master: Master) -> set[str]:
    """Return what nodes in /ns have at the master, without the random parts of their names."""
    words = zip(("pub", "sub", "srv"), master.call("getSystemState")[2], strict=True)
    found = {f"{word} {topic} {node}" for word, part in words for topic, nodes in part for node in nodes}
    return {re.sub(r"(_\d+)+", "_N", each) for each in found if " /ns/" in each and OURS_ALONE not in each}
