"""Fixtures for pytest, available automatically wherever pyros1 is installed.

| fixture | value |
|---|---|
| `ros_master` | a separate master on a free port; ROS_MASTER_URI and ROS_HOME are set for the duration of the test |
| `ros_node` | a function that creates nodes like `pyros1.Node` |
| `ros_listen` | a function that listens to a topic, and returns a `Heard` |
| `ros_run` | a function that starts a program of a package like `pyros1 run`, and returns a `Program` |
| `ros_launch` | a function that starts a launch file like `pyros1 launch`, and returns a `Program` |

Everything is shut down at the end of the test. pyros1 is not imported before a test uses one of these fixtures.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from pyros1.master.server import Master
    from pyros1.node import Node
    from pyros1.testing import Heard, Program


@pytest.fixture
def ros_master(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Master]:
    """A master on a free port of 127.0.0.1; see its ``uri``. Log files are written to the test's temporary folder."""
    from pyros1.master.server import Master

    server = Master(port=0, bind_host="127.0.0.1", advertised_host="127.0.0.1")
    server.start()
    for name in ("ROS_HOSTNAME", "ROS_NAMESPACE", "ROS_LOG_DIR", "ROS_IPV6"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("ROS_MASTER_URI", server.uri)
    monkeypatch.setenv("ROS_IP", "127.0.0.1")
    monkeypatch.setenv("ROS_HOME", str(tmp_path / "ros"))
    yield server
    server.stop()


@pytest.fixture
def ros_node(ros_master: Master) -> Iterator[Callable[..., Node]]:
    """Return a function that creates a node: ``ros_node(name, **options)``, like `pyros1.Node`, but without pytest's
    command line arguments, and without signal handlers.
    """
    from pyros1.node import Node

    with ExitStack() as nodes:

        def create(name: str, **options: Any) -> Node:
            node = Node(name, **{"argv": [], "handle_signals": False, **options})
            nodes.callback(node.shutdown)
            return node

        yield create


@pytest.fixture
def ros_listen(ros_node: Callable[..., Node]) -> Callable[[str, Any], Heard[Any]]:
    """Return a function that listens to a topic: ``ros_listen(topic, type)``; type is a message class or a name like
    "std_msgs/Float64". All topics of a test share one node.
    """
    from pyros1.testing.heard import Heard

    nodes: list[Node] = []

    def listen(topic: str, type: Any) -> Heard[Any]:
        if not nodes:
            nodes.append(ros_node("test_listener", anonymous=True))
        return Heard(nodes[0], topic, type)

    return listen


@pytest.fixture
def ros_run(ros_master: Master) -> Iterator[Callable[..., Program]]:
    """Return a function that starts a program: ``ros_run(package, program, *arguments, environ={})``; ``environ``
    is added to the environment.
    """
    with ExitStack() as programs:
        yield _starter("run", programs)


@pytest.fixture
def ros_launch(ros_master: Master) -> Iterator[Callable[..., Program]]:
    """Return a function that starts a launch file: ``ros_launch(path, "name:=value", ..., environ={})`` or
    ``ros_launch(package, file, ...)``; ``environ`` is added to the environment.
    """
    with ExitStack() as programs:
        yield _starter("launch", programs)


def _starter(command: str, programs: ExitStack) -> Callable[..., Program]:
    from pyros1.testing.programs import Program, pyros1_command

    def start(*arguments: object, environ: dict[str, str] | None = None) -> Program:
        program = Program(pyros1_command(command, *map(str, arguments)), {**os.environ, **(environ or {})})
        programs.callback(program.stop)
        return program

    return start
