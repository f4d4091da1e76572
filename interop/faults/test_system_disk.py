"""The disk is full: log files, journal and dumps say so once, keep what they have, and go on when there is room.

Feature: system faults: no file descriptors left, a full disk, a clock that jumps, hundreds of nodes at once
"""

from __future__ import annotations

import re
import resource
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from harness import Master, until
from vitals import limited

MASTERS = ("ours",)
TEXT = "std_msgs/String"


def fill(master: Master, count: int) -> None:
    """Let the master write into its journal and its log."""
    for number in range(count):
        assert master.call("setParam", f"/p{number % 10}", f"{number:06}" * 20)[0] == 1


def test_the_master(own_master: Callable[[str], Master]) -> None:
    master = own_master("ours")
    master.start()
    core = master.core[0]
    log = master.home / "log" / "latest" / "master.log"
    journal = next(master.home.glob("pyros1/*.journal"))
    fill(master, 20)
    until(lambda: "/p9" in log.read_text(), "the log")
    before = log.read_bytes()
    with limited(core.pid, resource.RLIMIT_FSIZE, 2000):
        fill(master, 200)
        core.wait_line("cannot write the log file .*: File too large", 60)
        core.wait_line("the journal .* cannot be written: File too large", 60)
        sink, source = master.ready_peer("roscpp", "sink"), master.ready_peer("rospy", "source")
        sink.subscribe("/t", TEXT)
        source.advertise("/t", TEXT)
        source.linked("/t")
        assert source.publish("/t") == sink.received("/t")
        assert not core.unread("File too large")
        assert log.read_bytes().startswith(before[: before.rindex(b"\n")])
    fill(master, 20)
    until(lambda: journal.exists() and b"p9" in journal.read_bytes(), "the journal is there again", 60)

    def logged() -> bool:
        fill(master, 1)
        return re.search(r"\.\.\. \d+ lines are missing here: File too large\n", log.read_text()) is not None

    until(logged, "the log goes on", 60)


def test_the_log_file_of_a_node(launcher: Master, topic: str) -> None:
    node, listener = launcher.ready_peer("pyros1", "writer"), launcher.ready_peer("roscpp", "listener")
    listener.subscribe("/rosout_agg", "rosgraph_msgs/Log")
    node.advertise(topic, TEXT)
    listener.subscribe(topic, TEXT)
    node.linked(topic)
    log = launcher.home / "log" / "writer.log"
    node.ask("log", "info", "before", event="logged info")
    before = log.read_bytes()
    with limited(node.pid, resource.RLIMIT_FSIZE, len(before) + 10):
        for number in range(50):
            node.ask("log", "info", f"lost {number}", event="logged info")
        node.wait_line("WARNING: cannot write the log file .*writer.log: File too large", 60)
        assert not node.unread("cannot write")
        assert node.publish(topic) == listener.received(topic)
        listener.event("got", "/rosout_agg")
    assert log.read_bytes().startswith(before)
    assert node.quit() == 0
    assert "Traceback" not in node.transcript()


@pytest.mark.parametrize("words", [("param", "dump")])
def test_a_dump_that_does_not_fit_leaves_the_old_one(launcher: Master, tmp_path: Path, words: tuple[str, ...]) -> None:
    path = tmp_path / "dump.yaml"
    command = [sys.executable, "-m", "pyros1", *words, str(path)]
    assert launcher.run(command, python="ours").wait(60) == 0
    before = path.read_bytes()
    assert b"rosdistro" in before
    small = launcher.run(["prlimit", "--fsize=10", *command], python="ours")
    assert small.wait(60) == 1
    assert small.lines == [f"ERROR: {path}: File too large"]
    assert path.read_bytes() == before and list(tmp_path.iterdir()) == [path]
