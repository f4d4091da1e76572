"""Files that are no bags are refused before a page opens."""

from __future__ import annotations

import errno
import os
import shutil
from pathlib import Path

import pytest

from pyros1.bag import BagWriter
from pyros1.bag.format.files import BagFile
from pyros1.cli.failures import CommandError
from pyros1.cli.shared.bag_files import check_bag


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("text", "FILE: this is not a bag file"),
        ("empty", "FILE: the file is empty: nothing was recorded"),
        ("cut", "FILE: the file ends in its first line; nothing can be recovered"),
        ("header", "FILE: at byte 13: the bag header cannot be read"),
        ("future", "FILE: bag version 3.0 is not supported; only 2.0 and 1.2 are"),
        ("folder", "FILE is a folder, not a bag"),
        ("pipe", "FILE: this is a pipe; bags can only be read from files"),
        ("loop", "cannot read FILE: Too many levels of symbolic links"),
        ("dangling", "there is no file FILE"),
    ],
)
def test_what_is_not_a_bag_opens_no_page(tmp_path: Path, kind: str, said: str) -> None:
    file = tmp_path / "x.bag"
    contents = {"text": b"root:x:0:0\n", "empty": b"", "cut": b"#ROSBAG", "header": b"#ROSBAG V2.0\nabc"}
    contents |= {"future": b"#ROSBAG V3.0\nabc"}
    if kind in contents:
        file.write_bytes(contents[kind])
    elif kind == "folder":
        file.mkdir()
    elif kind == "pipe":
        os.mkfifo(file)
    else:
        file.symlink_to(file if kind == "loop" else tmp_path / "nowhere")
    with pytest.raises(CommandError) as error:
        check_bag(str(file))
    assert str(error.value).startswith(said.replace("FILE", str(file)))
    assert "\n" not in str(error.value)


def test_a_bag_that_may_not_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: str) -> BagFile:  # root may read every file
        raise PermissionError(errno.EACCES, "Permission denied", path)

    monkeypatch.setattr("pyros1.cli.shared.bag_files.BagFile", refuse)
    with pytest.raises(CommandError, match=r"^cannot read /secret\.bag: Permission denied$"):
        check_bag("/secret.bag")


def test_a_bag_that_was_not_closed_opens(tmp_path: Path) -> None:
    file = tmp_path / "x.bag.active"
    header = {"topic": b"/x", "type": b"std_msgs/Empty", "md5sum": b"d41d8cd98f00b204e9800998ecf8427e"}
    with BagWriter(tmp_path / "x.bag") as bag:
        bag.write(bag.add_connection("/x", header | {"message_definition": b""}), 1, b"")
        bag.flush()
        shutil.copy(tmp_path / "x.bag", file)
    check_bag(str(file))
