"""The first words of a command line: names of stock's programs, and misspelt ones."""

from __future__ import annotations

import pytest

from pyros1.cli.main import entry


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
