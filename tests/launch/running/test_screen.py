"""Screen output with the node's name before each line; nothing that a node says is lost."""

from __future__ import annotations

import io
import os
import subprocess
import sys
import threading

import pytest

from pyros1.launch.running.process_spec import ProcessSpec
from pyros1.launch.running.screen import Screen


def show(screen: Screen, script: str, node: str = "/ns/node") -> None:
    words = ["sh", "-c", script]
    spec = ProcessSpec("node-1", node, words, {}, "/")
    with screen.open_outputs(spec) as (out, err):
        process = subprocess.Popen(words, stdout=out, stderr=err)
    process.wait()
    screen.close(20.0)
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("screen ")]


def test_every_line_has_the_name_and_the_last_needs_no_end() -> None:
    out, err = io.StringIO(), io.StringIO()
    show(Screen(out, err), "echo one; printf 'two\\nthree'; echo bad >&2")
    assert out.getvalue() == "[ns/node] one\n[ns/node] two\n[ns/node] three\n"
    assert err.getvalue() == "[ns/node] bad\n"


def test_much_output_of_a_node_that_is_killed_is_there_to_the_end() -> None:
    out = io.StringIO()
    show(Screen(out, io.StringIO()), "i=0; while [ $i -lt 3000 ]; do echo line $i; i=$((i + 1)); done; kill -9 $$")
    assert out.getvalue().splitlines()[-1] == "[ns/node] line 2999"


def test_names_are_coloured_the_same_each_time() -> None:
    screen = Screen(io.StringIO(), io.StringIO(), colour=True)
    one, other = screen.line_prefix("/a", sys.stdout), screen.line_prefix("/b", sys.stdout)
    assert one == screen.line_prefix("/a", sys.stdout)
    assert one.startswith(b"\033[") and one.endswith(b"\033[0m") and b"[a] " in one
    assert one[:5] != other[:5]


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo terminals here")
def test_nodes_see_a_terminal_where_there_is_one() -> None:
    out = Terminal()
    show(Screen(out, io.StringIO()), "if [ -t 1 ]; then echo terminal; fi; if [ ! -t 2 ]; then echo pipe >&2; fi")
    assert out.getvalue().endswith("\033[0mterminal\n")
