"""The first words of a command line: names of stock's programs, and misspelt ones."""

from __future__ import annotations

import pytest

from pyros1.cli.main import entry
from pyros1.ground.interrupts import INTERRUPTED_EXIT_CODE


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        ("rviz --nope", 2, "pyros1 web: error: no such option: --nope"),
        ("topic echo --nostrr /x", 2, "pyros1 topic: error: no such option: --nostrr (did you mean '--nostr'?)"),
        ("rqt_plot -p nothing", 2, "pyros1 web: error: option -p: invalid floating-point value: 'nothing'"),
        ("view_frames --nope", 2, "no such option: --nope"),
        ("rvizz", 64, "unknown command 'rvizz' (did you mean 'rviz'?)"),
        ("rqt_plt", 64, "unknown command 'rqt_plt' (did you mean 'rqt_plot'?)"),
        ("topci list", 64, "unknown command 'topci' (did you mean 'topic'?)"),
        ("bag rec", 64, "unknown command 'rec' (did you mean 'record'?)"),
        ("pkg crate my_robot", 1, "command crate not implemented (did you mean 'create'?)"),
        ("node inf", 64, "unknown command 'inf' (did you mean 'info'?)"),
    ],
)
def test_names_of_stocks_programs_and_misspelt_words(
    capsys: pytest.CaptureFixture[str], words: str, code: int, said: str
) -> None:
    try:
        found = entry(["pyros1", *words.split()])
    except SystemExit as end:
        found = int(str(end.code))
    assert found == code and said in capsys.readouterr().err


class Interrupting:
    """Raises KeyboardInterrupt while a class that contains it is created."""

    def __set_name__(self, owner: type, name: str) -> None:
        raise KeyboardInterrupt


def test_ctrl_c_while_a_class_is_created(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Python before 3.12 makes it a RuntimeError."""

    def run_command(command: str, arguments: list[str]) -> int:
        type("Created", (), {"field": Interrupting()})
        return 0

    monkeypatch.setattr("pyros1.cli.running.run_command", run_command)
    assert entry(["pyros1", "wtf"]) == INTERRUPTED_EXIT_CODE
    assert capsys.readouterr() == ("", "")


def test_other_runtime_errors_are_bugs(monkeypatch: pytest.MonkeyPatch) -> None:
    def run_command(command: str, arguments: list[str]) -> int:
        raise RuntimeError("a bug")

    monkeypatch.setattr("pyros1.cli.running.run_command", run_command)
    with pytest.raises(RuntimeError, match="a bug"):
        entry(["pyros1", "wtf"])
