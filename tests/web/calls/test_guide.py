"""The guide's calls: its exercises are checked from the page."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from pyros1.ground.errors import MasterUnreachableError
from pyros1.guide import checks
from pyros1.web import calls
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError


def test_an_exercise_is_checked_in_the_folder_and_at_the_master_of_the_server(
    robot: Robot, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    seen: list[tuple[int, str, Path]] = []

    def check(number: int, environ: Mapping[str, str], folder: Path) -> str:
        seen.append((number, environ["ROS_MASTER_URI"], folder))
        return "no node publishes /topic2"

    monkeypatch.setattr(checks, "check", check)
    answer = calls.run(robot, "guide.check", {"step": 2})
    assert answer == {"missing": "no node publishes /topic2", "folder": str(tmp_path)}
    assert seen == [(2, robot.master_uri, tmp_path)]


def test_a_real_check(robot: Robot) -> None:
    assert calls.run(robot, "guide.check", {"step": 2})["missing"] == "no node publishes /topic2"


@pytest.mark.parametrize("step", [0, 16, "1", True, None])
def test_steps_that_there_are_not(robot: Robot, step: object) -> None:
    with pytest.raises(RequestError, match="a number from 1 to 15"):
        calls.run(robot, "guide.check", {"step": step})


def test_who_may_not_check(make_robot: Callable[..., Robot]) -> None:
    with pytest.raises(RequestError, match="read-only"):
        calls.run(make_robot(read_only=True), "guide.check", {"step": 1})
    with pytest.raises(RequestError, match="run pyros1 guide check 1"):
        calls.run(make_robot(topics=("/a",)), "guide.check", {"step": 1})


def test_a_check_that_fails_says_why(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    def check(*_: object) -> str:
        raise MasterUnreachableError("no master")

    monkeypatch.setattr(checks, "check", check)
    with pytest.raises(MasterUnreachableError, match="no master"):
        calls.run(robot, "guide.check", {"step": 1})
