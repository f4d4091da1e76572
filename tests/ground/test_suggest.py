"""suggest: what misspelt words were meant to be.

Feature: errors for wrong arguments, misspelt imports, types and options suggest what was probably meant
"""

from __future__ import annotations

import pytest

from pyros1.ground.suggest import argument_hint, did_you_mean, similar_option, similar_remapping

EN_DASH, EM_DASH, MINUS = "\u2013", "\u2014", "\u2212"


def test_the_nearest_word() -> None:
    assert did_you_mean("scren", ["screen", "other"]) == " (did you mean 'screen'?)"
    assert did_you_mean("ls", ["list", "lst"]) == " (did you mean 'list'?)"
    assert did_you_mean("x", ["screen"]) == did_you_mean("screen", ["screen"]) == ""


@pytest.mark.parametrize(
    ("word", "known", "meant"),
    [
        ("rec", ["record", "reindex"], "record"),
        ("re", ["record", "reindex"], ""),
        ("r", ["record"], ""),
        ("/rob", ["/robot/speed"], "/robot/speed"),
        ("std_msgs/", ["std_msgs/Time"], ""),
        ("rename", ["rename-topic", "retime"], "rename-topic"),
        ("ech", ["echo", "echoes"], "echo"),
    ],
)
def test_the_beginning_of_a_word(word: str, known: list[str], meant: str) -> None:
    assert did_you_mean(word, known) == (f" (did you mean '{meant}'?)" if meant else "")


@pytest.mark.parametrize(
    ("word", "known", "meant"),
    [
        ("std_msgs/Nope", "std_msgs/Time", None),
        ("std_msgs/string", "std_msgs/String", "std_msgs/String"),
        ("/robot/left/nope", "/robot/left/mode", None),
        ("/robt/speed", "/robot/speed", "/robot/speed"),
        ("/robot/sped", "/robot/speed", "/robot/speed"),
        ("sensor_msgs/IMU", "sensor_msgs/Imu", "sensor_msgs/Imu"),
        ("/CHATTER", "/chatter", "/chatter"),
        ("/foo/get_loggers", "/rosout/get_loggers", None),
        ("/srvv/get_loggers", "/srv/get_loggers", "/srv/get_loggers"),
        ("nope.launch", "p.launch", None),
        ("minimal_nods.launch", "minimal_nodes.launch", "minimal_nodes.launch"),
        ("robot.lanch", "robot.launch", "robot.launch"),
    ],
)
def test_what_names_share_makes_them_not_near(word: str, known: str, meant: str | None) -> None:
    assert did_you_mean(word, [known]) == (f" (did you mean '{meant}'?)" if meant else "")


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        (f"{EN_DASH}r", "-r"),
        (f"{EM_DASH}screen", "--screen"),
        (f"{EN_DASH}{EN_DASH}rate=5", "--rate=5"),
        (f"-{MINUS}wait-for", "--wait-for"),
        ("-r", None),
        ("--screen", None),
        (f"{EN_DASH} a text", None),
        (f"{EN_DASH}5", None),
        ("größe", None),
        ("", None),
    ],
)
def test_dashes_of_printed_texts(word: str, meant: str | None) -> None:
    assert similar_option(word) == meant
    assert argument_hint(word).endswith(f"write {meant}" if meant else "")


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("foo=1", "foo:=1"),
        ("lambda: 1", None),
        ("_rate=10", "_rate:=10"),
        ("__name=left", "__name:=left"),
        ("rate:10", "rate:=10"),
        ("/a/b=/c", "/a/b:=/c"),
        ("~x=/dev/null", "~x:=/dev/null"),
        ("foo=:1", "foo:=1"),
        ("text=a b\nc", "text:=a b\nc"),
        ("foo:=1", None),
        ("foo:=a=b", None),
        ("--rate=10", None),
        ("-Dx=1", None),
        ("http://host:11311/", None),
        ("C:\\robot", None),
        ("robot:11311", None),
        ("12:30", None),
        ("a==1", None),
        ("foo", None),
        ("foo=", None),
        ("=", None),
        ("", None),
    ],
)
def test_remappings_that_are_none(word: str, meant: str | None) -> None:
    assert similar_remapping(word) == meant
    assert argument_hint(word).endswith(f"write {meant}" if meant else "")
