"""`bag play` as a user calls it."""

from __future__ import annotations

import os
import signal
import struct
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from pyros1.bag import BagWriter
from pyros1.msgs.std_msgs.msg import Float64, String

from ...bodies import encode

DEADLINE = 20.0
BEGIN = 1_700_000_000 * 10**9


def fields(cls: Any, **more: str) -> dict[str, bytes]:
    header = {"type": cls._type, "md5sum": cls._md5sum, "message_definition": cls._full_text, **more}
    return {name: value.encode() for name, value in header.items()}


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """Numbers on /t, one each millisecond for 0.1 s, and a latched text on /map."""
    path = tmp_path / "x.bag"
    with BagWriter(path) as writer:
        text = writer.add_connection("/map", fields(String, callerid="/mapper", latching="1"))
        conn = writer.add_connection("/t", fields(Float64, callerid="/talker"))
        writer.write(text, BEGIN, encode(String("m")))
        for number in range(100):
            writer.write(conn, BEGIN + number * 10**6, struct.pack("<d", number))
    return path


class Heard:
    """The values of a topic."""

    def __init__(self, node: Any, topic: str, cls: Any = Float64) -> None:
        self.data: list[Any] = []
        self._changed = threading.Condition()
        self.subscriber = node.subscribe(topic, cls, self._take)

    def _take(self, message: Any) -> None:
        with self._changed:
            self.data.append(message.data)
            self._changed.notify_all()

    def wait(self, count: int) -> list[Any]:
        with self._changed:
            assert self._changed.wait_for(lambda: len(self.data) >= count, DEADLINE), self.data
            return list(self.data)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        ([], 2, "at least 1 bag file"),
        (["nope.bag"], 1, "nope.bag: No such file"),
        (["--rate", "0", "x.bag"], 2, "--rate"),
        (["--hz", "-1", "x.bag"], 2, "--hz"),
        (["--start", "-1", "x.bag"], 2, "--start"),
        (["--start", "7", "x.bag"], 1, "only 0.099 s long"),
        (["x.bag", "--topics", "/tt"], 1, "did you mean '/t'"),
        (["unindexed.bag"], 1, "reindex"),
        (["foreign.bag"], 1, "not a bag"),
    ],
)
def test_wrong_arguments(start: Any, bag: Path, words: list[str], code: int, text: str) -> None:
    """L145: unlike stock's, failures have an exit code."""
    (bag.parent / "foreign.bag").write_text("hello")
    (bag.parent / "unindexed.bag").write_bytes(bag.read_bytes()[:-100])
    child = start("bag", "play", *words)
    _, err = child.communicate(timeout=DEADLINE)
    assert child.returncode == code and text in err, err


@pytest.mark.slow
def test_waits_for_subscribers_and_remaps(start: Any, make_node: Any, bag: Path) -> None:
    child = start("bag", "play", "--wait-for-subscribers", "-d", "0", "--topics", "/t", "--bags", "x.bag", "/t:=/u")
    while "Waiting for subscribers" not in (line := child.stdout.readline()):
        assert line, child.stderr.read()
    heard = Heard(make_node("ear"), "/u")
    assert heard.wait(100) == list(map(float, range(100)))
    out, err = child.communicate(timeout=DEADLINE)
    assert (child.returncode, err) == (0, "") and "Done." in out


@pytest.mark.slow
def test_stays_for_latched_topics_until_it_is_told_to_end(start: Any, make_node: Any, bag: Path) -> None:
    child = start("bag", "play", "-k", "-i", "-d", "0", "x.bag")
    while "still running" not in (line := child.stdout.readline()):
        assert line, child.stderr.read()
    assert Heard(make_node("late"), "/map", String).wait(1) == ["m"]
    child.send_signal(signal.SIGINT)
    _, err = child.communicate(timeout=DEADLINE)
    assert (child.returncode, err) == (0, "")


@pytest.mark.slow
def test_quiet_says_nothing(start: Any, bag: Path, master: Any) -> None:
    child = start("bag", "play", "-q", "-i", "-d", "0", "x.bag")
    assert child.communicate(timeout=DEADLINE) == ("", "") and child.returncode == 0


@pytest.mark.slow
def test_nobody_reads_what_it_says_about_an_empty_bag(start: Any, tmp_path: Path, master: Any) -> None:
    BagWriter(tmp_path / "empty.bag").close()
    child = start("bag", "play", "-d", "0.1", "empty.bag")
    child.stdout.close()
    assert child.stderr.read() == "WARNING: no messages to play\n"
    assert child.wait(DEADLINE) == 0
    child.stdout = None  # for whoever ends what is left


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no terminals of that kind")
def test_keys_step_and_resume(start: Any, make_node: Any, bag: Path) -> None:
    """B35"""
    import fcntl
    import pty
    import termios

    ours, theirs = pty.openpty()

    def own_terminal() -> None:
        os.setsid()
        fcntl.ioctl(0, termios.TIOCSCTTY, 0)

    heard = Heard(make_node("ear"), "/t")
    child = start(
        "bag", "play", "--pause", "--topics", "/t", "--wait-for-subscribers", "--bags", "x.bag",
        stdin=theirs, preexec_fn=own_terminal,
    )  # fmt: skip
    try:
        while "Hit space" not in (line := child.stdout.readline()):
            assert line, child.stderr.read()
        os.write(ours, b"s")
        assert heard.wait(1) == [0.0]
        os.write(ours, b"xs")
        assert heard.wait(2) == [0.0, 1.0]
        os.write(ours, b" ")
        assert heard.wait(100) == list(map(float, range(100)))
        _, err = child.communicate(timeout=DEADLINE)
        assert (child.returncode, err) == (0, "")
    finally:
        os.close(ours)
        os.close(theirs)


@pytest.mark.skipif(sys.platform == "win32", reason="no terminals of that kind")
def test_the_terminal_is_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    import pty
    import termios

    from pyros1.bag.play.control import Control
    from pyros1.bag.play.keyboard import Keyboard

    ours, theirs = pty.openpty()
    monkeypatch.setattr("os.tcgetpgrp", lambda descriptor: os.getpgrp())
    control = Control()
    try:
        before = termios.tcgetattr(theirs)
        with os.fdopen(os.dup(theirs)) as stdin:
            monkeypatch.setattr("sys.stdin", stdin)
            with Keyboard(control) as keyboard:
                assert keyboard.is_available and not termios.tcgetattr(theirs)[3] & termios.ICANON
                os.write(ours, b" t")
                control.wait(DEADLINE)
                assert control.is_paused and not control.pause_on_topics
                termios.tcsetattr(theirs, termios.TCSADRAIN, before)  # as shells do with jobs that are stopped
                signal.raise_signal(signal.SIGCONT)
                assert not termios.tcgetattr(theirs)[3] & termios.ICANON, "the job goes on in the foreground"
                with monkeypatch.context() as patch:
                    patch.setattr("os.tcgetpgrp", lambda descriptor: -1)
                    signal.raise_signal(signal.SIGCONT)
                    os.write(ours, b" ")
                    control.wait(0)
                    assert control.is_paused, "in the background keys are for others"
            assert termios.tcgetattr(theirs) == before
            monkeypatch.setattr("os.tcgetpgrp", lambda descriptor: -1)
            with Keyboard(control) as keyboard:
                assert not keyboard.is_available, "a job in the background leaves the terminal alone"
    finally:
        control.close()
        os.close(ours)
        os.close(theirs)


@pytest.mark.slow
def test_the_service_pauses(start: Any, make_node: Any, bag: Path) -> None:
    """B29"""
    from pyros1.msgs.std_srvs.srv import SetBool

    node = make_node("ear")
    heard = Heard(node, "/t")
    child = start("bag", "play", "--pause", "--topics", "/t", "--bags", "x.bag", "__name:=player")
    node.wait_for_service("/player/pause_playback", DEADLINE)
    pause = node.service("/player/pause_playback", SetBool)
    answer = pause(True)
    assert (answer.success, answer.message) == (False, "Bag is already paused.")
    assert heard.subscriber.wait_for_publishers(timeout=DEADLINE)
    answer = pause(False)
    assert (answer.success, answer.message) == (True, "Playback is now resumed")
    heard.wait(100)
    assert child.communicate(timeout=DEADLINE)[1] == ""


@pytest.mark.slow
def test_a_recording_that_is_broken_in_the_middle_ends_with_the_reason(start: Any, bag: Path, master: Any) -> None:
    data = bytearray(bag.read_bytes())
    at = data.index(b"compression=none")
    data[at : at + 16] = b"compression=nono"
    (bag.parent / "broken.bag").write_bytes(data)
    child = start("bag", "play", "-d", "0", "broken.bag")
    _, err = child.communicate(timeout=DEADLINE)
    assert child.returncode == 1 and "nono" in err and "reindex" in err


@pytest.mark.slow
def test_ends_at_once_in_the_middle_of_a_gap(start: Any, make_node: Any, tmp_path: Path) -> None:
    with BagWriter(tmp_path / "gap.bag") as writer:
        conn = writer.add_connection("/t", fields(Float64))
        writer.write(conn, BEGIN, bytes(8))
        writer.write(conn, BEGIN + 10**15, bytes(8))
    heard = Heard(make_node("ear"), "/t")
    child = start("bag", "play", "--wait-for-subscribers", "gap.bag")
    heard.wait(1)
    begun = time.monotonic()
    child.send_signal(signal.SIGTERM)
    child.communicate(timeout=DEADLINE)
    assert child.returncode == 0 and time.monotonic() - begun < DEADLINE
