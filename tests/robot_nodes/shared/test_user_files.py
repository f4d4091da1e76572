from __future__ import annotations

import os
import random
import re
from pathlib import Path

import pytest

from pyros1.robot_nodes.shared.user_files import read_regular_file, yaml_number


def test_what_is_no_file_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to(tmp_path / "pipe")
    for path in (tmp_path / "pipe", tmp_path / "link", "/dev/zero", "/dev/null"):
        with pytest.raises(OSError, match="not a regular file, but a pipe or a device"):
            read_regular_file(str(path), 10)
    with pytest.raises(IsADirectoryError):
        read_regular_file(str(tmp_path), 10)
    with pytest.raises(FileNotFoundError):
        read_regular_file(str(tmp_path / "none"), 10)
    with pytest.raises(ValueError, match="null byte"):
        read_regular_file("a\0b", 10)
    (tmp_path / "file").write_bytes(b"12345")
    (tmp_path / "pipe").unlink()
    (tmp_path / "link").unlink()
    (tmp_path / "link").symlink_to(tmp_path / "file")
    assert (
        read_regular_file(str(tmp_path / "link"), 10) == b"12345"
        and read_regular_file(str(tmp_path / "file"), 3) == b"123"
    )


def test_numbers_as_programs_write_them() -> None:
    chance = random.Random(3)
    for _ in range(300):
        number = chance.choice(
            [0.0, 1e-5, 1e22, chance.uniform(-1, 1), chance.uniform(-1, 1) * 10 ** chance.randint(-30, 30)]
        )
        for text in (repr(number), f"{number:g}", f"{number:.17e}", f"{number:+.3E}"):
            assert yaml_number(text) == float(text)
        assert yaml_number(number) == number
    assert (
        yaml_number("1e5") == 1e5 and yaml_number(".5e1") == 5.0 and yaml_number("3.") == 3.0 and yaml_number(7) == 7.0
    )


@pytest.mark.parametrize(
    "value", ["", "e5", "1e", "0x10", "1_0", "nan", "1e999", "1 ", "." + "1" * 200, True, None, [1]]
)
def test_what_is_no_number(value: object) -> None:
    assert yaml_number(value) is None


def test_random_texts_never_raise() -> None:
    chance = random.Random(5)
    for _ in range(2000):
        text = "".join(chance.choices("0123456789.eE+-x", k=chance.randint(0, 9)))
        number = yaml_number(text)
        assert (number is not None) == bool(
            re.match(r"^[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?$", text)
        ) or number is None
