"""Stock programs with windows: what their words are for the page."""

from __future__ import annotations

import pytest

from pyros1.cli.failures import UsageError
from pyros1.cli.shared.gui_programs import (
    GUI_PROGRAMS,
    PROGRAMS_BY_PACKAGE,
    first_argument_index,
    has_display,
    select_image_topic,
    translate_call,
)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("rqt_graph --force-discover -f -ht -l -t -v --clear-config", ["graph"]),
        ("rqt_plot -b pyside -P /a/x -e", ["plot", "--start-paused", "/a/x", "--empty"]),
        ("rqt_plot --pause --qt-binding=pyqt /a/x", ["plot", "--start-paused", "/a/x"]),
        ("rqt -s rqt_bag --args run.bag", ["--open", "--standalone", "rqt_bag", "run.bag"]),
        ("rqt_gui --standalone=rqt_plot", ["--open", "--standalone", "rqt_plot"]),
        ("rxplot -P -p 5 /a/x", ["plot", "--start-paused", "-p", "5", "/a/x"]),
        ("rviz -t /base_link", ["scene", "--target-frame", "/base_link"]),
        ("rviz -l -s splash.png --fixed-frame odom", ["scene", "--fixed-frame", "odom"]),
        ("rxgraph -o graph.dot", ["graph", "--output", "graph.dot"]),
        ("image_view /camera --port 0", ["image", "/camera", "--port", "0"]),
    ],
)
def test_words(line: str, words: list[str]) -> None:
    program, *given = line.split()
    assert translate_call(program, given) == (words, [])


@pytest.mark.parametrize(
    "line",
    [
        "rqt -p mine",
        "rxplot -b 5",
        "rxplot --refresh=2",
        "rxplot -m o",
        "rxplot -t x",
        "rxplot -l a",
        "rxplot -M 3d",
        "rqt_graph --perspective-file=x.perspective",
        "rqt --command-pid 7",
    ],
)
def test_what_somebody_would_miss_is_told_once(line: str) -> None:
    program, *given = line.split()
    words, notes = translate_call(program, [*given, *given])
    assert words == [*GUI_PROGRAMS[program].args]
    assert len(notes) == 1


@pytest.mark.parametrize("line", ["rqt -s", "rqt_graph --perspective-file", "rviz --fullscreen=yes"])
def test_wrong_options(line: str) -> None:
    program, *given = line.split()
    with pytest.raises(UsageError, match=given[-1].partition("=")[0]):
        translate_call(program, given)


def test_every_program_takes_a_page() -> None:
    assert {name for names in PROGRAMS_BY_PACKAGE.values() for name in names} <= {*GUI_PROGRAMS}
    for name in GUI_PROGRAMS:
        assert translate_call(name, ["--read-only"]).args[-1] == "--read-only"


@pytest.mark.parametrize(
    ("line", "place"), [("", 0), ("rviz", 0), ("--open -p 3 rviz", 3), ("-p=3 rviz", 1), ("-p", 1), ("--open", 1)]
)
def test_the_first_argument(line: str, place: int) -> None:
    assert first_argument_index(line.split(), {"-p"}) == place


def test_the_topic_of_image_view() -> None:
    assert select_image_topic([], "/c", "") == ["/c"]
    assert select_image_topic(["raw"], "/c", "compressed") == ["/c"]
    assert select_image_topic(["compressed"], "/c/", "") == ["/c/compressed"]
    assert select_image_topic(["/d"], "/c", "compressed") == ["/d/compressed"]
    assert select_image_topic([], "", "compressed") == []


def test_browsers_need_a_display_on_linux() -> None:
    assert not has_display({"DISPLAY": ""}, "linux")
    assert has_display({"WAYLAND_DISPLAY": "wayland-0"}, "linux")
    assert has_display({"BROWSER": "firefox"}, "linux")
    assert has_display({}, "darwin")
