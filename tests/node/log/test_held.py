"""A node whose terminal, pipe or disk is held goes on serving; what others do to it fills no disk.

Feature: a blocked terminal or pipe does not block a node -- repeated log lines about peers are counted
"""

from __future__ import annotations

import fcntl
import os
import select
import signal
import subprocess
import sys
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.ground.errors import ServiceError
from pyros1.ground.timing import Time
from pyros1.launch.running.core import Core
from pyros1.net.hosts import LocalAddress
from pyros1.net.master_client import MasterClient
from pyros1.net.rate_limit import MAX_TEXTS
from pyros1.node.log.logger import Log
from pyros1.node.log.sink import LogSink

from ...parts import context_of

BAD = {"topic": "/nothing", "md5sum": "*", "type": "*"}


class HeldStream:
    """A terminal that is held by Ctrl-S."""

    encoding, errors = "utf-8", "strict"

    def __init__(self) -> None:
        self.go_on = threading.Event()
        self.text = ""

    def isatty(self) -> bool:
        return False

    def write(self, text: str) -> None:
        assert self.go_on.wait(20), "written while it is held"
        self.text += text

    def flush(self) -> None:
        assert self.go_on.wait(20)


def test_a_held_terminal_makes_no_node_deaf(
    make_node: Any, raw_peer: Any, call_node: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    node, stream = make_node("talker"), HeldStream()
    monkeypatch.setattr("sys.stderr", stream)
    for number in range(5):
        assert "not a publisher" in raw_peer(node).greet(**BAD, callerid=f"/peer{number}").answer()["error"]
    assert call_node(node, "getPid", "/tool")[0] == 1
    stream.go_on.set()
    node.shutdown()
    assert [line.split("connection from ")[1].split(" ")[0] for line in stream.text.splitlines()] == [
        f"/peer{number}" for number in range(5)
    ]


def test_what_pyros1_says_of_callbacks_waits_for_no_terminal(
    make_node: Any, collect: Any, transport: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The traceback of a callback, which logs nothing itself, keeps no thread of the node from the next one."""
    node, got, stream = make_node("listener"), collect(), HeldStream()

    def fail(request: Any) -> None:
        got(request)
        raise ValueError("on purpose")

    node.subscribe("t", "std_msgs/Float64", fail)
    node.advertise_service("s", "std_srvs/Trigger", fail)
    timer_calls = collect()
    publisher, client = make_node("talker").advertise("t", "std_msgs/Float64"), node.service("s", "std_srvs/Trigger")
    assert publisher.wait_for_subscribers(timeout=10)
    with monkeypatch.context() as patch:
        patch.setattr("sys.stderr", stream)
        node.timer(0.001, lambda event: fail(timer_calls(event)))
        for number in range(3):
            publisher.publish(number)
            with pytest.raises(ServiceError, match="on purpose"):
                client()
        got.until(lambda items: sum(hasattr(item, "data") for item in items) == 3)
        timer_calls.wait(3)
        node.subscribe("other", "std_msgs/Float64", got)
        stream.go_on.set()
        node.shutdown()
    assert stream.text.count(" of /t\n") == stream.text.count("error processing a request of /s") == 3


def test_what_pyros1_says_comes_before_what_the_program_says_next(make_node: Any, capsys: Any) -> None:
    node = make_node("n", rosout=False)
    for number in range(20):
        context_of(node).loop.report(ValueError(f"theirs {number}"))
        node.log.error("ours %d", number)
    said = [line for line in capsys.readouterr().err.splitlines() if "ours" in line or "theirs" in line]
    assert ["ours" in line for line in said] == [False, True] * 20


def unread(path: Path) -> int:
    """Make a pipe in place of a log file, and return its reading end, which waits for lines."""
    os.mkfifo(path)
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    os.set_blocking(reader, True)
    return reader


def test_a_held_log_file_makes_no_node_deaf(make_node: Any, raw_peer: Any, call_node: Any, tmp_path: Path) -> None:
    reader = unread(tmp_path / "node.log")
    node = make_node("talker", argv=[f"__log:={tmp_path}/node.log"])
    assert raw_peer(node).greet(**BAD, callerid="/peer").answer()["error"]
    assert call_node(node, "getPid", "/tool")[0] == 1
    assert select.select([reader], [], [], 20)[0]  # until the node has opened the pipe, it reads as if it had ended
    with open(reader) as log:
        assert "refused a connection from /peer" in log.readline()
        node.shutdown()


def test_a_held_log_file_makes_no_master_deaf(tmp_path: Path, free_port: int) -> None:
    reader = unread(tmp_path / "master.log")
    address = LocalAddress("127.0.0.1", "127.0.0.1", ())
    core = Core(
        port=free_port,
        address=address,
        uri=f"http://127.0.0.1:{free_port}/",
        log_folder=tmp_path,
        environ={},
        on_shutdown=lambda reason: None,
    )
    core.start_master()
    client = MasterClient("/tool", f"http://127.0.0.1:{free_port}/")
    client.set_param("/forged\n[rosmaster.master][INFO] all is well", 1)
    assert client.get_pid() == os.getpid()
    with open(reader) as log:
        client.close()
        core.stop_master()
        lines = log.read().splitlines()
    assert len(lines) == 2 and "+PARAM [/forged\\n[rosmaster" in lines[1]


def test_what_peers_do_again_and_again_is_counted(make_node: Any, raw_peer: Any, watch_log: Any) -> None:
    node = make_node("talker")
    log = watch_log(node)
    for _ in range(38):
        raw_peer(node).greet(**BAD, callerid="/rude").answer()
    for number in range(3 * MAX_TEXTS):
        raw_peer(node).greet(service="/nothing", md5sum="*", callerid=f"/rude{number}").answer()
    for _ in range(5):
        raw_peer(node).greet(nothing="useful").answer()
    node.shutdown()
    refused = [text for text in log.texts if "refused" in text]
    rude = [text for text in refused if "from /rude for" in text]
    assert rude[0].startswith("refused a connection from /rude for /nothing: [/talker] is not a publisher")
    assert rude[1:] == [rude[0] + " (repeated 37 times)"]
    assert len([text for text in refused if "/rude" in text]) == MAX_TEXTS + 1, "the first one counts as one"
    assert any(f"{2 * MAX_TEXTS + 1} similar messages" in text for text in log.texts)
    assert len([text for text in refused if "names no topic or service" in text]) == 2


def test_an_internal_error_that_a_peer_repeats_is_counted(
    make_node: Any, call_node: Any, watch_log: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    node = make_node("talker")
    log = watch_log(node)
    monkeypatch.setattr("pyros1.node.slave.os", SimpleNamespace(getpid=lambda: 1 // 0))
    for _ in range(5):
        with pytest.raises(Exception, match="division"):
            call_node(node, "getPid", "/tool")
    node.shutdown()
    texts = [text for text in log.texts if "ZeroDivisionError" in text]
    assert len(texts) == 2 and texts[1].endswith("(repeated 4 times)")


PROGRAM = """
import sys
import pyros1
node = pyros1.Node("talker")
node.log.info("ready %s", node.master.lookup_service("/talker/get_loggers"))
if "crash" in sys.argv:
    node.log.warn("the last words")
    import os
    os._exit(3)
node.spin()
"""


def test_a_pipe_that_nobody_reads_harms_nobody_and_keeps_what_fits(
    environ: dict[str, str], raw_peer: Any, service_port: Any
) -> None:
    reader, writer = os.pipe()
    if hasattr(fcntl, "F_SETPIPE_SZ"):
        fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, 4096)  # what is logged is much more
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM], env={**os.environ, **environ}, stdout=subprocess.PIPE, stderr=writer, text=True
    )
    os.close(writer)
    assert process.stdout is not None
    try:
        port = service_port(process.stdout.readline().split()[-1])
        for number in range(2 * MAX_TEXTS):
            peers = raw_peer(port).greet(topic="/t" + "x" * 8000, md5sum="*", callerid=f"/{number}" + "y" * 8000)
            assert peers.answer()["error"]
        for number in range(2 * MAX_TEXTS):
            raw_peer(port).greet(service="/s" + "x" * 8000, md5sum="*", callerid=f"/{number}" + "y" * 8000).answer()
        process.send_signal(signal.SIGTERM)
        assert process.wait(20) == 0
        with open(reader, closefd=False) as pipe:
            text = pipe.read()
        assert "refused a connection from /0yyy" in text and "more characters" in text
    finally:
        process.kill()
        process.wait(20)
        process.stdout.close()
        os.close(reader)


def test_what_a_program_logs_is_out_before_it_crashes(environ: dict[str, str]) -> None:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, "crash"],
        env={**os.environ, **environ},
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert done.returncode == 3
    assert "ready" in done.stdout and "the last words" in done.stderr


def test_a_closed_log_keeps_what_was_written_and_takes_no_more(tmp_path: Path) -> None:
    path = tmp_path / "n.log"
    sink = LogSink("/n", {}, str(path), lambda: (Time.from_sec(1000.0), False))
    log = Log(sink)
    log.info("before")
    sink.close()
    log.info("after")
    sink.close()
    assert "before" in path.read_text() and "after" not in path.read_text()
