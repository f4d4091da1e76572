"""The reference: each public name has a docstring, the code in these runs, and the pages are made without a warning.

Feature: an API reference -- `python interop/reference.py` (extra `docs`); the code in docstrings is run
"""

from __future__ import annotations

import asyncio
import importlib.util
import inspect
import os
import re
import signal
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import pyros1
import pyros1.aio
import pyros1.bag
from pyros1 import actions
from pyros1.msgs import from_definition, load_message
from pyros1.msgs.actionlib_tutorials.msg import FibonacciAction, FibonacciGoal, FibonacciResult
from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.nav_msgs.msg import Odometry
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.tf import StaticTransformBroadcaster

ROOT = Path(__file__).resolve().parents[1]
PATIENCE = 30.0

pytestmark = pytest.mark.once


def _reference() -> Any:
    """The program that makes the reference."""
    spec = importlib.util.spec_from_file_location("reference", ROOT / "interop" / "reference.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def documented() -> Iterator[tuple[str, str]]:
    """Yield the public names, with the public parts of classes, and their docstrings."""
    for module in _reference().modules():
        yield module.__name__, module.__doc__ or ""
        for name in module.__all__:
            value = getattr(module, name)
            if not (inspect.isclass(value) or inspect.isroutine(value)):
                continue  # constants, and modules that have their own turn
            yield f"{module.__name__}.{name}", inspect.getdoc(value) or ""
            for part, its in vars(value).items() if inspect.isclass(value) else ():
                if not part.startswith("_") and (inspect.isroutine(its) or isinstance(its, property)):
                    yield f"{module.__name__}.{name}.{part}", inspect.getdoc(getattr(value, part)) or ""


NAMES = dict(documented())
BLOCKS = {
    name: textwrap.dedent(block[1])
    for name, text in NAMES.items()
    if (block := re.search(r"::\n\n((?: {4}.*\n|\n)+)", f"{text}\n"))
}
PROGRAMS = [name for name, code in BLOCKS.items() if re.search(r"^(async )?with pyros1.Node|asyncio.run", code, re.M)]
TESTS = ["pyros1.testing"]


def test_all_public_names_are_documented() -> None:
    """The figure of interop/README.md."""
    assert not [name for name, text in NAMES.items() if not text]
    said = re.search(r"(\d+) of (\d+) public names", (ROOT / "interop" / "README.md").read_text(encoding="utf-8"))
    assert said is not None and int(said[1]) == int(said[2]) and abs(int(said[2]) - len(NAMES)) <= 20, len(NAMES)


@pytest.mark.slow
def test_public_names_and_signatures_change_only_on_purpose() -> None:
    """CHANGELOG promises those of a release. In a new process, as the drop-in rospy changes a method of AnyMsg."""
    command = [sys.executable, str(ROOT / "interop" / "reference.py"), "--names"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    promised = (ROOT / "interop" / "public_names.txt").read_text(encoding="utf-8")
    assert done.stdout == promised, (
        "if this is intended: python interop/reference.py --names > interop/public_names.txt"
    )


@pytest.mark.slow
def test_the_pages_are_made_without_a_warning(tmp_path: Path) -> None:
    pytest.importorskip("pdoc", reason="the extra docs is not installed")
    command = [sys.executable, str(ROOT / "interop" / "reference.py"), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=200, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    page = (tmp_path / "pyros1.html").read_text(encoding="utf-8")
    missing = [name for name in dir(pyros1.Node) if name[0] != "_" and f'id="Node.{name}"' not in page]
    assert not missing


TELLS = """
import pyros1.aio

def tell(kind, name):
    do = getattr(kind, name)
    def told(*args, **options):
        print("it is there", flush=True)
        return do(*args, **options)
    setattr(kind, name, told)

tell(pyros1.Node, "spin")
tell(pyros1.Node, "ok")
tell(pyros1.aio.Node, "messages")
"""
"""Goes before a program: says when all is made, and the program begins to wait."""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT")
@pytest.mark.parametrize("name", PROGRAMS)
def test_programs(name: str, make_node: Any, environ: dict[str, str]) -> None:
    """They find what they need, run as nodes, and end on Ctrl-C if not before."""
    code = BLOCKS[name]
    world = make_node("world")
    place = TransformStamped(child_frame_id="base_link")
    place.header.frame_id = "map"
    place.transform.rotation.w = 1.0
    StaticTransformBroadcaster(world).send_transform(place)
    command = [sys.executable, "-c", TELLS + code]
    with (
        actions.SimpleServer(world, "fibonacci", FibonacciAction, lambda goal: FibonacciResult(sequence=[0, 1])),
        subprocess.Popen(
            command, env={**os.environ, **environ}, stdout=subprocess.PIPE, stderr=subprocess.PIPE
        ) as child,
    ):
        try:
            if "timeout=" not in code:  # it runs until it is told to end
                assert child.stdout is not None and any(line == b"it is there\n" for line in child.stdout)
                child.send_signal(signal.SIGINT)
            wrong = child.communicate(timeout=PATIENCE)[1]
        finally:
            child.kill()
    assert (child.returncode, wrong) == (0, b"")


@pytest.mark.parametrize("name", [name for name in BLOCKS if name not in PROGRAMS + TESTS])
def test_parts_of_programs(
    name: str, make_node: Any, environ: dict[str, str], tmp_path: Path, monkeypatch: Any
) -> None:
    """With the names that they speak of."""
    monkeypatch.chdir(tmp_path)
    code = BLOCKS[name]
    header = {"type": "a/B", "message_definition": "float64 x"}
    known: dict[str, Any] = {
        "pyros1": pyros1, "actions": actions, "load_message": load_message, "from_definition": from_definition,
        "FibonacciAction": FibonacciAction, "FibonacciGoal": FibonacciGoal, "FibonacciResult": FibonacciResult,
        "DriveAction": FibonacciAction, "DriveResult": FibonacciResult, "header": header, "message": Odometry(),
        "stamp": 1000.0, "node": make_node("one"), "print": lambda *_: None,
    }  # fmt: skip
    with pyros1.bag.open("run.bag", "w") as bag:
        for topic, message in (("/odom", Odometry()), ("/scan", Float64(1.0))):
            bag.write(topic, message, 1015.0)
    if "pandas" in code:
        known["pandas"] = pytest.importorskip("pandas")
    with pyros1.bag.open("run.bag") as known["bag"]:
        if "async " not in code:
            exec(code, known)
            for value in known.values():
                if isinstance(value, actions.SimpleServer):
                    value.close()
            return

        async def main() -> None:
            async with pyros1.aio.Node("two", argv=[], environ=environ, handle_signals=False) as known["node"]:
                exec("async def part():\n" + textwrap.indent(code, "    "), known)
                await known["part"]()

        def execute(goal: Any) -> FibonacciResult:
            return FibonacciResult(sequence=[0, 1, 1])

        with actions.SimpleServer(make_node("server"), "fibonacci", FibonacciAction, execute):
            asyncio.run(main())


CONTROLLER = """#!/usr/bin/env python3
import pyros1

with pyros1.Node("controller") as node:
    force = node.advertise("force_cmd", "std_msgs/Float64", latch=True)
    node.subscribe("velocity", "std_msgs/Float64", lambda velocity: force.publish(data=-velocity.data))
    node.spin()
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="a script with #!")
def test_tests(tmp_path: Path) -> None:
    package = tmp_path / "my_robot"
    (package / "scripts").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>my_robot</name></package>")
    (package / "scripts" / "controller.py").write_text(CONTROLLER)
    (package / "scripts" / "controller.py").chmod(0o755)
    (tmp_path / "test_it.py").write_text(BLOCKS["pyros1.testing"])
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--disable-plugin-autoload"]
    command += ["-p", "pyros1_pytest", "test_it.py"]
    around = {**os.environ, "ROS_PACKAGE_PATH": str(tmp_path), "PYTHONPATH": str(ROOT / "src")}
    done = subprocess.run(command, cwd=tmp_path, env=around, capture_output=True, text=True, timeout=90, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
