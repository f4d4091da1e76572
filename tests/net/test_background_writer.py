"""background: who may not wait has its lines written, in order, and as far as there is time."""

from __future__ import annotations

import contextlib
import io
import os
import sys
import threading
from typing import Any

import pytest

from pyros1.cli.clean_output import CleanStream
from pyros1.net import background_writer
from pyros1.net.background_writer import BackgroundWriter, write_to_terminal


class Sink:
    """A place that can be held."""

    def __init__(self) -> None:
        self.free = threading.Event()
        self.entered = threading.Event()
        self.texts: list[str] = []

    def __call__(self, items: Any, should_stop: Any) -> None:
        self.entered.set()
        while not self.free.wait(0.01):
            if should_stop():
                return
        self.texts += [text for _, text in items]


@pytest.fixture
def sink() -> Sink:
    return Sink()


def test_nothing_waits_and_the_order_is_kept(sink: Sink) -> None:
    writer = BackgroundWriter("test", sink)
    for number in range(100):
        writer.write("", f"{number}\n")
    sink.free.set()
    writer.close()
    assert sink.texts == [f"{number}\n" for number in range(100)]


def test_the_thread_goes_when_there_is_nothing_to_write(sink: Sink, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(background_writer, "IDLE_TIMEOUT", 0.01)
    sink.free.set()
    writer = BackgroundWriter("test writer", sink)
    for text in ("a", "b"):
        writer.write("", text)
        for thread in threading.enumerate():
            if thread.name == "test writer":
                thread.join(5)
                assert not thread.is_alive()
    assert sink.texts == ["a", "b"]


def test_what_is_too_much_is_lost_and_counted(sink: Sink, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(background_writer, "MAX_PENDING", 10)
    writer = BackgroundWriter("test", sink)
    writer.write("", "first\n")
    assert sink.entered.wait(5)
    for text in ("second\n", "lost\n", "lost too\n"):
        writer.write("", text)
    sink.free.set()
    writer.close()
    assert sink.texts == ["first\n", "second\n", "... 2 lines were lost here: the output was too slow\n"]


def test_the_end_is_not_held_up(sink: Sink) -> None:
    writer = BackgroundWriter("test", sink)
    writer.write("", "nobody takes it")
    writer.close(timeout=0.05)
    assert sink.texts == []


class FullPipe:
    """A pipe without room as this process's real stderr."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.reader, self._writer = os.pipe()
        self.stream = os.fdopen(self._writer, "w", encoding="ascii", errors="backslashreplace")
        monkeypatch.setattr(sys, "stderr", self.stream)  # not in a fixture: pytest puts its own there for each phase
        monkeypatch.setattr(sys, "__stderr__", self.stream)
        os.set_blocking(self._writer, False)
        self._filled = 0
        with contextlib.suppress(BlockingIOError):
            while True:
                self._filled += os.write(self._writer, b"-" * 4096)
        os.set_blocking(self._writer, True)

    def empty(self) -> None:
        while self._filled:
            self._filled -= len(os.read(self.reader, min(self._filled, 65536)))

    def close(self) -> None:
        self.stream.close()
        os.close(self.reader)


def test_a_full_pipe_takes_its_text_when_it_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    with contextlib.closing(FullPipe(monkeypatch)) as pipe:
        writer = BackgroundWriter("test", write_to_terminal)
        writer.write("stderr", "sp\xe4t\n")
        pipe.empty()
        writer.close(timeout=10)
        os.set_blocking(pipe.reader, False)
        assert os.read(pipe.reader, 100) == b"sp\\xe4t\n"


def test_a_full_pipe_that_nobody_reads_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    with contextlib.closing(FullPipe(monkeypatch)):
        writer = BackgroundWriter("test", write_to_terminal)
        writer.write("stderr", "never\n")
        writer.close(timeout=0.05)


@pytest.mark.parametrize("stream", [None, "closed"])
def test_a_missing_terminal_stops_nothing(monkeypatch: pytest.MonkeyPatch, stream: Any) -> None:
    if stream:
        stream = io.StringIO()
        stream.close()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(sys, "__stderr__", stream)
    write_to_terminal([("stderr", "x\n")], lambda: False)


def test_a_filter_in_front_of_the_terminal_is_passed_by(monkeypatch: pytest.MonkeyPatch) -> None:
    """Log lines are clean already, and keep their colours whatever the command's own output may contain."""
    terminal = io.StringIO()
    monkeypatch.setattr(sys, "stderr", CleanStream(terminal))
    write_to_terminal([("stderr", "\x1b[33mwarned\x1b[0m\n")], lambda: False)
    assert terminal.getvalue() == "\x1b[33mwarned\x1b[0m\n"
