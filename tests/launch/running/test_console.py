"""launch.running.console: the lines and the title of a launch's terminal."""

from __future__ import annotations

import io

import pytest

from pyros1.cli.clean_output import CleanStream
from pyros1.launch.running.console import Console


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("shows_title", [True, False])
def test_a_title_is_not_escaped_by_the_stream_of_a_command_l167(shows_title: bool) -> None:
    terminal = Terminal()
    Console(CleanStream(terminal), terminal, title=shows_title).set_title("robot.launch")  # type: ignore[arg-type]
    assert terminal.getvalue() == ("\033]2;robot.launch\007" if shows_title else "")


def test_a_file_has_no_title() -> None:
    file = io.StringIO()
    Console(file, file).set_title("robot.launch")
    assert file.getvalue() == ""
