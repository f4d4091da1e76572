"""Words on the command line, names of files, choice of topics, and what a recording says about itself."""

from __future__ import annotations

import io
import re
import time
from typing import Any

import pytest

from pyros1.bag.record.file_names import FileNames
from pyros1.bag.record.model import Topic
from pyros1.bag.record.topic_selection import TopicSelection
from pyros1.cli.commands.bag._running.status import RecordingStatus, StatusLine, format_size, recording_summary
from pyros1.cli.commands.bag.record import VERB
from pyros1.cli.invocation import Invocation
from pyros1.ground.errors import Error

MOMENT = time.mktime((2026, 11, 20, 20, 24, 3, 0, 0, -1))


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (FileNames(), "2026-11-20-20-24-03.bag"),
        (FileNames("pre"), "pre_2026-11-20-20-24-03.bag"),
        (FileNames("dir/pre.bag"), "dir/pre_2026-11-20-20-24-03.bag"),
        (FileNames("name", has_date=False), "name.bag"),
        (FileNames("name.bag", has_date=False), "name.bag"),
        (FileNames("pre", has_number=True), "pre_2026-11-20-20-24-03_7.bag"),
        (FileNames("name.bag", has_date=False, has_number=True), "name_7.bag"),
        (FileNames(has_number=True), "2026-11-20-20-24-03_7.bag"),
    ],
)
def test_names(names: FileNames, expected: str) -> None:
    """B17"""
    assert names.name(7, MOMENT) == expected


def test_selection() -> None:
    """B15: expressions match whole names; what is excluded is so however it was found, but not if it was named."""
    every = TopicSelection(all_topics=True, exclude="/cam.*")
    assert every.selects("/odom") and not every.selects("/cam1") and every.needs_polling
    some = TopicSelection(["/cam[0-9]", "/odom"], uses_regex=True, exclude=".*9")
    assert some.selects("/cam1") and not some.selects("/cam12") and not some.selects("/cam9")
    assert not some.selects("/my/odom") and some.fixed_topics() == []
    node = TopicSelection(node="/n")
    assert node.selects("/a", ["/a"]) and not node.selects("/b", ["/a"]) and node.needs_polling
    plain = TopicSelection(["/a"], exclude="/a")
    assert plain.fixed_topics() == ["/a"] and not plain.needs_polling
    with pytest.raises(Error, match=r"not a regular expression"):
        TopicSelection(exclude="(")


@pytest.mark.parametrize("words", [["--split=5"], ["--split", "5"], ["--split", "--size", "5"]], ids=" ".join)
def test_the_old_form_of_split_has_a_size_b19(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert VERB.parse is not None
    options, topics = VERB.parse(Invocation("bag", "rosbag", ["record", *words, "/t"]), VERB)
    assert (options.split, options.size, topics) == (True, 5, ["/t"])
    assert ("has been deprecated" in capsys.readouterr().err) is ("--size" not in words)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_messages_and_the_live_line_do_not_mix() -> None:
    out = Terminal()
    line = StatusLine(stream=out)
    line.show("x" * 1000)
    line.print_message("hello")
    line.show("y")
    line.clear()
    lines = re.split(r"[\r\n]", out.getvalue().replace("\x1b[K", ""))
    assert re.fullmatch(r"\[ INFO\] \[\d+\.\d{9}\]: hello", lines[2])
    assert len(lines[1]) < 1000 and lines[3:] == ["", "y", ""]


def test_nothing_but_messages_goes_into_a_file_and_nothing_at_all_if_quiet() -> None:
    out, quiet = io.StringIO(), Terminal()
    for line in (StatusLine(stream=out), StatusLine(False, quiet)):
        line.show("x")
        line.print_message("hello")
        line.clear()
    assert out.getvalue().count("\n") == 1 and "x" not in out.getvalue()
    assert quiet.getvalue() == ""


def test_an_output_that_goes_away_does_not_end_the_recording() -> None:
    out = Terminal()
    line = StatusLine(stream=out)
    out.close()
    line.show("x")
    line.print_message("hello")
    line.clear()


def test_topics_that_lose_messages_come_first() -> None:
    recorder: Any = type("Recorder", (), {})()
    busy, losing = Topic("/busy", messages=1000, bytes=10_000_000), Topic("/losing", messages=10, bytes=10, dropped=3)
    losing.received_after_end = 2
    recorder.topics = {"/busy": busy, "/losing": losing}
    recorder.size = 12_345_678
    recorder.report = type("Report", (), {"files": ["a.bag"], "messages": 1005, "bytes": 12_345_678})()
    text = RecordingStatus(recorder).text()
    assert "12.3 MB" in text and "DROPPED 3" in text
    assert text.index("/losing") < text.index("/busy")
    table = recording_summary(recorder).split("\n")
    assert table[0] == "1005 messages, 12.3 MB in 1 file"
    assert re.fullmatch(r"  /losing +5 messages +10 B  3 dropped", table[2])


def test_sizes_for_people() -> None:
    assert [format_size(size) for size in (0, 999, 1500, 2_000_000, 3.21e12)] == [
        "0 B", "999 B", "1.5 KB", "2 MB", "3.21 TB"
    ]  # fmt: skip
