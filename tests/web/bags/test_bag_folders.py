"""The folders whose bags pages may see."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from pyros1.web.bags.bag_folders import BagFolders
from pyros1.web.bags.granted_files import GrantedFiles
from pyros1.web.server.wire import RequestError


@pytest.fixture
def bags(tmp_path: Path) -> Path:
    folder = tmp_path / "bags"
    (folder / "inner").mkdir(parents=True)
    for name in ("a.bag", "b.bag.active", "notes.txt", ".hidden.bag", "inner/c.bag"):
        (folder / name).write_bytes(b"x")
    (tmp_path / "secret.bag").write_bytes(b"x")
    return folder


def test_a_folder_lists_its_bags_and_folders(bags: Path) -> None:
    listing = BagFolders([str(bags)]).listing("")
    assert listing["folder"] == str(bags)
    assert [each["name"] for each in listing["files"]] == ["a.bag", "b.bag.active"]
    assert [each["name"] for each in listing["folders"]] == ["inner"]
    assert listing["files"][0]["size"] == 1
    assert listing["up"] is None
    assert not listing["more"]
    assert listing["writable"]


def test_a_folder_into_which_nothing_can_be_recorded(bags: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: not mode & os.W_OK)  # root may write everywhere
    assert not BagFolders([str(bags)]).listing("")["writable"]


def test_an_inner_folder_leads_up_and_no_higher(bags: Path) -> None:
    bag_folders = BagFolders([str(bags)])
    assert bag_folders.listing(str(bags / "inner"))["up"] == str(bags)
    with pytest.raises(RequestError, match="--bags"):
        bag_folders.listing(str(bags.parent))


def test_several_folders_are_listed_first(bags: Path, tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    bag_folders = BagFolders([str(bags), str(tmp_path / "other"), str(tmp_path / "missing")])
    listing = bag_folders.listing("")
    assert [each["path"] for each in listing["folders"]] == [str(bags), str(tmp_path / "other")]
    assert bag_folders.listing(str(bags))["up"] == ""


def test_without_folders_nothing_is_seen(bags: Path) -> None:
    bag_folders = BagFolders([])
    assert bag_folders.listing("")["folders"] == []
    for text in (str(bags), "/", "."):
        with pytest.raises(RequestError, match="--bags"):
            bag_folders.find_folder(text)


@pytest.mark.parametrize("path", ["../secret.bag", "inner/../../secret.bag", "inner/../../../etc/passwd"])
def test_dots_do_not_lead_out(bags: Path, path: str) -> None:
    with pytest.raises(RequestError, match="outside"):
        BagFolders([str(bags)]).find_file(f"{bags}/{path}")


def test_links_that_lead_out_are_neither_shown_nor_followed(bags: Path, tmp_path: Path) -> None:
    os.symlink(tmp_path / "secret.bag", bags / "link.bag")
    os.symlink(tmp_path, bags / "way_out")
    os.symlink(bags / "a.bag", bags / "within.bag")
    bag_folders = BagFolders([str(bags)])
    listing = bag_folders.listing("")
    assert [each["name"] for each in listing["files"]] == ["a.bag", "b.bag.active", "within.bag"]
    assert [each["name"] for each in listing["folders"]] == ["inner"]
    for name in ("link.bag", "way_out/secret.bag"):
        with pytest.raises(RequestError, match="outside"):
            bag_folders.find_file(str(bags / name))
    with pytest.raises(RequestError, match="outside"):
        bag_folders.find_folder(str(bags / "way_out"))
    assert bag_folders.find_file(str(bags / "within.bag")) == bags / "a.bag"


def test_a_folder_with_a_similar_name_is_outside(bags: Path, tmp_path: Path) -> None:
    (tmp_path / "bags2").mkdir()
    with pytest.raises(RequestError, match="outside"):
        BagFolders([str(bags)]).find_folder(str(tmp_path / "bags2"))


def test_a_file_of_the_command_line_may_be_anywhere(bags: Path, tmp_path: Path) -> None:
    bag_folders = BagFolders([str(tmp_path / "secret.bag")])
    assert bag_folders.find_file(str(tmp_path / "secret.bag")) == tmp_path / "secret.bag"
    with pytest.raises(RequestError, match="outside"):
        bag_folders.find_file(str(bags / "a.bag"))


def test_only_files_are_opened(bags: Path) -> None:
    os.mkfifo(bags / "pipe.bag")
    bag_folders = BagFolders([str(bags)])
    for name, words in (
        ("inner", "not a file"),
        ("pipe.bag", "not a file"),
        ("missing.bag", "No such file"),
        ("a\0b", "path|file"),
    ):
        with pytest.raises(RequestError, match=words):
            bag_folders.find_file(str(bags / name))
    assert "pipe.bag" not in [each["name"] for each in bag_folders.listing("")["files"]]


def test_files_that_the_user_names_later(bags: Path, tmp_path: Path) -> None:
    granted = GrantedFiles(tmp_path / "new" / "list")
    bag_folders = BagFolders([str(bags)], granted)
    secret, other = tmp_path / "secret.bag", tmp_path / "other\n.bag"
    other.write_bytes(b"x")
    for path in (secret, other):
        with pytest.raises(RequestError, match="outside"):
            bag_folders.find_file(str(path))
    granted.add([str(secret)])
    granted.add([str(other)])
    assert [bag_folders.find_file(str(path)) for path in (secret, other)] == [secret, other]
    with pytest.raises(RequestError, match="outside"):
        bag_folders.find_folder(str(tmp_path))  # nothing is recorded there
    granted.clear()
    with pytest.raises(RequestError, match="outside"):
        bag_folders.find_file(str(secret))
