"""robot: the server's node is started again and again until it runs."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.web.robot import Robot
from pyros1.web.server.access import Access


def test_a_start_for_which_no_files_can_be_opened_is_tried_again(
    environ: dict[str, str], make_node: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.web.robot.RETRY_DELAY", 0.01)
    made: list[Any] = []
    attempts: list[int] = []

    def refuse(*_: Any, **__: Any) -> None:
        raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))

    def make() -> Any:
        attempts.append(1)
        if len(attempts) == 1:
            refuse()
        made.append(make_node(f"web{len(made)}"))
        if len(made) == 1:
            monkeypatch.setattr(made[0], "subscribe", refuse)
        return made[-1]

    robot = Robot(environ["ROS_MASTER_URI"], Access(), make)
    robot.start()
    try:
        assert robot.wait_for_node(10)
        assert robot.node is made[1] and len(attempts) == 3 and not robot.problem
    finally:
        robot.close()
