"""whole_file: an old file stays as it was until the new one is complete."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path
from typing import Any

import pytest

from pyros1.ground.atomic_file import write_atomically


def test_new_and_old_files(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    write_atomically(path, "ä: 1\n")
    path.chmod(0o640)
    write_atomically(str(path), "b: 2\n")
    assert path.read_bytes() == b"b: 2\n" and stat.S_IMODE(path.stat().st_mode) == 0o640
    assert list(tmp_path.iterdir()) == [path]


def test_behind_a_link_is_the_file_that_is_meant(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link.yaml").symlink_to("real/a.yaml")
    for text in ("1\n", "2\n"):
        write_atomically(tmp_path / "link.yaml", text)
        assert (tmp_path / "link.yaml").is_symlink() and (tmp_path / "real" / "a.yaml").read_text() == text


def test_a_full_disk_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.yaml"
    path.write_text("old\n")
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def replace(*_: Any) -> None:
        raise full

    monkeypatch.setattr("pyros1.ground.atomic_file.os.replace", replace)
    with pytest.raises(OSError, match="No space left") as caught:
        write_atomically(path, "new\n")
    assert caught.value.filename == str(path)
    assert path.read_text() == "old\n" and list(tmp_path.iterdir()) == [path]


def test_a_folder_that_cannot_be_changed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.yaml"
    path.write_text("old\n")

    def replace(*_: Any) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr("pyros1.ground.atomic_file.os.replace", replace)
    write_atomically(path, "new\n")
    assert path.read_text() == "new\n" and list(tmp_path.iterdir()) == [path]


def test_pipes_and_devices_are_written_directly(tmp_path: Path) -> None:
    write_atomically(os.devnull, "text\n")
    assert stat.S_ISCHR(os.stat(os.devnull).st_mode)
    with pytest.raises(OSError, match="No space left"):
        write_atomically("/dev/full", "text\n")
    with pytest.raises(FileNotFoundError) as caught:
        write_atomically(tmp_path / "none" / "a.yaml", "text\n")
    assert caught.value.filename == str(tmp_path / "none" / "a.yaml")
