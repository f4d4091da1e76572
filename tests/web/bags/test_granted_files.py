"""The list of bags that a terminal names."""

from __future__ import annotations

import json
import os
import stat
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.web.bags import granted_files as granted_module
from pyros1.web.bags.bag_folders import BagFolders
from pyros1.web.bags.granted_files import GrantedFiles
from pyros1.web.server.wire import RequestError


def test_a_bag_that_is_added_again_is_in_the_list_once(tmp_path: Path) -> None:
    granted = GrantedFiles(tmp_path / "list")
    for _ in range(3):
        granted.add([f"{tmp_path}/a.bag", f"{tmp_path}/b.bag", f"{tmp_path}/./a.bag"])
    assert [json.loads(line) for line in (tmp_path / "list").read_text().splitlines()] == [
        f"{tmp_path}/a.bag",
        f"{tmp_path}/b.bag",
    ]
    assert stat.S_IMODE((tmp_path / "list").stat().st_mode) == 0o600
    assert [each.name for each in tmp_path.iterdir()] == ["list"]


def test_the_list_is_bounded_and_keeps_the_newest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(granted_module, "MAX_LIST_SIZE", 2000)
    file = tmp_path / "list"
    granted = GrantedFiles(file)
    for number in range(200):
        granted.add([f"/bags/{number}.bag"])
        assert Path(f"/bags/{number}.bag") in granted
        assert file.stat().st_size <= 2000
    assert Path("/bags/100.bag") in granted and Path("/bags/0.bag") not in granted
    with pytest.raises(OSError, match="too many bags at once"):
        granted.add([f"/more/{number}.bag" for number in range(200)])
    assert Path("/bags/199.bag") in granted  # as before


def test_bags_beyond_the_first_megabyte_count(tmp_path: Path) -> None:
    granted = GrantedFiles(tmp_path / "list")
    for half in "ab":
        granted.add([f"/{half * 200}/{number}.bag" for number in range(3000)])
    assert Path(f"/{'b' * 200}/2999.bag") in granted


@pytest.mark.slow
@given(st.lists(st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), min_size=1), max_size=6))
def test_any_names(tmp_path_factory: pytest.TempPathFactory, names: list[str]) -> None:
    granted = GrantedFiles(tmp_path_factory.mktemp("any") / "list")
    paths = [os.path.realpath(f"/nowhere/{name}") for name in names]
    granted.add(paths)
    assert all(Path(path) in granted for path in paths)
    assert Path("/nowhere") / "not\nthere" not in granted or "/nowhere/not\nthere" in paths


@pytest.mark.parametrize("damage", [b"", b"\n\n", b"\xff\xfe\n", b'{"a": 1}\n"/cut'])
def test_a_damaged_list_is_written_anew(tmp_path: Path, damage: bytes) -> None:
    file = tmp_path / "list"
    file.write_bytes(damage)
    file.chmod(0o600)
    granted = GrantedFiles(file)
    assert Path("/cut") not in granted
    granted.add(["/a.bag"])
    assert Path("/a.bag") in granted


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="users of Unix")
@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("writable", r"can be read or written by other users \(mode 622\): remove this file"),
        ("readable", r"can be read or written by other users \(mode 604\): remove this file"),
        ("group", r"can be read or written by other users \(mode 620\): remove this file"),
        ("link", "is a symbolic link: remove this file"),
        ("dangling", "is a symbolic link: remove this file"),
        ("pipe", "is not a regular file: remove this file"),
        ("owner", "belongs to another user: remove this file"),
    ],
)
def test_a_list_that_is_not_to_be_trusted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, said: str
) -> None:
    file, bag = tmp_path / "list", tmp_path / "secret.bag"
    bag.touch()
    granted = GrantedFiles(tmp_path / "good")
    granted.add([str(bag)])
    assert bag in granted
    if kind == "pipe":
        os.mkfifo(file, 0o600)
    elif kind in ("link", "dangling"):
        file.symlink_to(tmp_path / ("good" if kind == "link" else "nowhere"))
    else:
        (tmp_path / "good").rename(file)
        file.chmod({"writable": 0o622, "readable": 0o604, "group": 0o620}.get(kind, 0o600))
        if kind == "owner":
            user = os.geteuid()
            monkeypatch.setattr(os, "geteuid", lambda: user + 1)
    granted = GrantedFiles(file)
    assert bag not in granted
    with pytest.raises(RequestError, match="outside"):
        BagFolders([], granted).find_file(str(bag))
    with pytest.raises(OSError, match=said) as error:
        granted.add([str(bag)])
    assert error.value.filename == str(file)
    assert not (tmp_path / "nowhere").exists()
