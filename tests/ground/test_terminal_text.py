"""shown: what others sent reaches a terminal without what would steer it."""

from __future__ import annotations

import pytest

from pyros1.ground import terminal_text

HOSTILE = "\x1b[2J\x07\x9b1m\x7f\u202e\u2028\r\udc80"
SHOWN = r"\x1b[2J\x07\x9b1m\x7f\u202e\u2028\r\udc80"


def test_controls_are_shown_as_in_a_string() -> None:
    assert terminal_text.one_line(f"a{HOSTILE}b") == terminal_text.lines(f"a{HOSTILE}b") == f"a{SHOWN}b"


@pytest.mark.parametrize("text", ["", "/robot/arm", "zwei Wörter", "日本語", "שלום", "👩\u200d🔬"])
def test_plain_text_stays(text: str) -> None:
    assert terminal_text.one_line(text) == terminal_text.lines(text) == terminal_text.coloured_lines(text) == text


def test_line_breaks_and_tabs_are_ours_or_not() -> None:
    assert terminal_text.one_line("a\r\n\tb") == r"a\r\n\tb"
    assert terminal_text.lines("a\r\n\tb\rc") == "a\r\n\tb\\rc"


def test_colours_of_a_program_stay() -> None:
    assert terminal_text.coloured_lines("\x1b[1;31mred\x1b[0m\x1b[2Jx\x1b]0;title\x07") == (
        "\x1b[1;31mred\x1b[0m\\x1b[2Jx\\x1b]0;title\\x07"
    )


def test_what_is_no_text_and_what_is_long() -> None:
    assert terminal_text.one_line(17) == "17"
    assert terminal_text.one_line("x" * 50, max_length=10) == "xxxxxxxxxx... (40 more characters)"


def test_every_control_character_is_known() -> None:
    for code in [
        *range(0x20),
        *range(0x7F, 0xA0),
        0x61C,
        0x200E,
        0x200F,
        *range(0x2028, 0x202F),
        *range(0x2066, 0x206A),
    ]:
        assert terminal_text.one_line(chr(code)) == repr(chr(code))[1:-1]


def test_bytes_that_are_no_text_may_stay_in_names_of_files() -> None:
    assert terminal_text.lines("gr\udcfcn\x1b") == "gr\\udcfcn\\x1b"
    assert terminal_text.lines("gr\udcfcn\x1b", keep_bytes=True) == "gr\udcfcn\\x1b"
