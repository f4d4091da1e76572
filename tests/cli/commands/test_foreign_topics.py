"""Commands on topics of other client libraries."""

from __future__ import annotations

import os
import signal
import struct
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from pyros1.cli.main import entry
from pyros1.msgs import AnyMsg
from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.wire.handshake import TopicType


@pytest.fixture
def run(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, call_main: Any) -> Any:
    for key, value in environ.items():
        monkeypatch.setenv(key, value)
    return partial(call_main, entry, "pyros1")


@pytest.mark.parametrize("text", ["", "%", "Vector3 linear\nVector3 angular\n"])
def test_echo_shows_what_other_client_libraries_send(run: Any, make_node: Callable[..., Any], text: str) -> None:
    """Their definitions are odd, and bytes are behind their messages; what cannot be decoded costs only itself."""
    board = make_node("board", rosout=False)
    kind = TopicType(Twist._type, Twist._md5sum, text)
    bodies = [b"too short", struct.pack("<6d", 1, 2, 3, 4, 5, 6) + b"\x55"]
    for number, body in enumerate(bodies):
        node = board if number else make_node("broken", rosout=False)
        node.advertise("cmd_vel", AnyMsg, raw_type=kind, latch=True).publish(AnyMsg(body))
    code, out, err = run("topic", "echo", "-n", "1", "/cmd_vel/angular")
    assert (code, out) == (0, "x: 4.0\ny: 5.0\nz: 6.0\n---\n")
    assert "Traceback" not in err and err.count("a message on /cmd_vel cannot be shown") <= 1


@pytest.mark.slow
@pytest.mark.parametrize("words", [["hz", "--filter", "m.data > 0"], ["delay"]], ids=str)
def test_rates_say_what_cannot_be_decoded(
    environ: dict[str, str], make_node: Callable[..., Any], words: list[str]
) -> None:
    kind = TopicType("own_msgs/Unknown", "1" * 32, "%")
    make_node("board", rosout=False).advertise("t", AnyMsg, raw_type=kind, latch=True).publish(AnyMsg(b"1234"))
    command = [sys.executable, "-m", "pyros1", "topic", *words, "/t"]
    with subprocess.Popen(command, env={**os.environ, **environ}, stderr=subprocess.PIPE, text=True) as child:
        assert child.stderr is not None
        line = child.stderr.readline()
        child.send_signal(signal.SIGINT)
        rest = child.stderr.read()
    assert "own_msgs/Unknown" in line and "[%] is not of the form" in line
    assert "Traceback" not in line + rest
