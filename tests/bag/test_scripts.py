"""The scripts of the package rosbag under their own names (L146)."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import pyros1.bag
from pyros1.bag import BagWriter
from pyros1.cli import bag as command
from pyros1.msgs import from_definition, load_message

from .conftest import Make
from .made import header_of

OLD = from_definition("std_msgs/Int32", "int16 value")
NEW = load_message("std_msgs/Int32")
SCRIPTS = Path(command.__file__).parents[1] / "packages" / "rosbag" / "scripts"
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, call_main: Any, tmp_path: Path) -> Run:
    monkeypatch.chdir(tmp_path)
    return partial(call_main, command.main)


def write(path: Path, *messages: tuple[str, int, Any], **header: str) -> Path:
    with BagWriter(path) as writer:
        for topic, time, message in messages:
            number = writer.add_connection(topic, header_of(type(message), callerid="/talker", **header))
            writer.write(number, time, type(message)._encode(message))
    return path


def content(path: str) -> list[tuple[str, int, str, str]]:
    with pyros1.bag.open(path) as bag:
        return [
            (stored.connection.topic, stored.time, stored.connection.type, stored.connection.md5sum)
            for stored in bag.reader.messages()
        ]


def test_every_script_is_known() -> None:
    assert sorted(path.name for path in SCRIPTS.glob("*.py")) == sorted(command._SCRIPTS)


@pytest.mark.parametrize("script", ["bagsort.py", "fastrebag.py"])
def test_messages_by_time(run: Run, tmp_path: Path, script: str) -> None:
    write(tmp_path / "x.bag", ("/a", 30, NEW(data=3)), ("/b", 10, NEW(data=1)), ("/a", 20, NEW(data=2)))
    assert run(script, "x.bag", "y.bag")[0] == 0
    assert [(topic, time) for topic, time, *_ in content("y.bag")] == [("/b", 10), ("/a", 20), ("/a", 30)]
    assert run(script, "x.bag", "x.bag")[0] == 1
    assert run(script, "none.bag", "z.bag")[0] == 1
    assert not Path("z.bag").exists()


def test_topic_renamer(run: Run, make_bag: Make) -> None:
    make_bag()
    assert run("topic_renamer.py", "/a", "x.bag", "/c", "y.bag")[0] == 0
    assert {topic for topic, *_ in content("y.bag")} == {"/c", "/b"}
    code, _, err = run("topic_renamer.py", "/none", "x.bag", "/c", "y.bag")
    assert (code, "has no topic /none" in err) == (1, True)


def test_a_rule_for_a_saved_definition_and_its_use(run: Run, tmp_path: Path) -> None:
    """savemsg, makerule and fixbag work hand in hand."""
    write(tmp_path / "old.bag", ("/a", 1, OLD(value=7)))
    code, text, _ = run("savemsg.py", "-b", "old.bag", "std_msgs/Int32")
    assert (code, text) == (0, "[std_msgs/Int32]:\nint16 value\n")
    Path("msg.saved").write_text(text)
    assert run("fixbag.py", "old.bag", "new.bag")[:2] == (1, "Bag could not be migrated.\n")
    code, out, _ = run("makerule.py", "msg.saved", "rules.bmr")
    assert (code, "1 rules missing" in out, "written to: rules.bmr" in out) == (0, True, True)
    assert "already exists" in run("makerule.py", "msg.saved", "rules.bmr")[2]
    rules = Path("rules.bmr").read_text()
    update = "def update(self, old_msg, new_msg):"
    rules = rules.replace("valid = False", "valid = True")
    Path("rules.bmr").write_text(rules.replace(update, f"{update}\n        new_msg.data = old_msg.value"))
    assert "No additional rule files needed" in run("makerule.py", "msg.saved", "rules.bmr", "-a")[1]
    assert run("fixbag.py", "old.bag", "new.bag", "rules.bmr")[:2] == (0, "Bag migrated successfully.\n")
    with pyros1.bag.open("new.bag") as bag:
        assert [message.message.data for message in bag.messages()] == [7]
    assert run("fixbag.py", "old.bag", "new.bmr")[0] == 2


def test_a_definition_of_this_system(run: Run) -> None:
    code, text, _ = run("savemsg.py", "std_msgs/Int32")
    assert (code, text) == (0, f"[std_msgs/Int32]:\n{NEW._full_text}\n")
    Path("msg.saved").write_text(text)
    assert run("makerule.py", "msg.saved", "rules.bmr") == (0, "Saved definition is up to date.\n", "")
    Path("msg.saved").write_text("int32 data\n")
    code, _, err = run("makerule.py", "msg.saved", "rules.bmr")
    assert (code, "[package/Type]" in err) == (1, True)
    assert run("savemsg.py", "std_msgs/None")[0] == 1


def test_bags_that_are_replaced(run: Run, make_bag: Make, tmp_path: Path) -> None:
    make_bag()
    write(tmp_path / "old.bag", ("/a", 1, OLD(value=7)))
    before = Path("x.bag").read_bytes()
    code, out, _ = run("fixbag_batch.py", "x.bag", "old.bag", "none.bag")
    assert code == 1
    assert "Trying to migrate: x.bag\n Migration successful.  Original stored as: x.bag.old\n" in out
    assert "Trying to migrate: old.bag\n Migration failed.\n" in out
    assert Path("x.bag.old").read_bytes() == before
    assert run("fix_md5sums.py", "x.bag")[0] == 0
    assert len(content("x.bag")) == 100
    assert sorted(path.name for path in tmp_path.iterdir()) == ["old.bag", "x.bag", "x.bag.old", "x.bag.old2"]


def test_definitions_that_are_wrong(run: Run, tmp_path: Path) -> None:
    write(tmp_path / "x.bag", ("/a", 1, NEW(data=1)), message_definition="int8 wrong")
    assert run("fix_msg_defs.py", "x.bag", "y.bag")[0] == 0
    with pyros1.bag.open("y.bag") as bag:
        assert [(each.definition, each.md5sum) for each in bag.connections] == [(NEW._full_text, NEW._md5sum)]
    write(tmp_path / "x.bag", ("/a", 1, NEW(data=1)), message_definition="int8 wrong", md5sum="0" * 32)
    code, _, err = run("fix_msg_defs.py", "x.bag", "y.bag")
    assert (code, "is not known here" in err) == (0, True)


def test_types_that_moved(run: Run, tmp_path: Path) -> None:
    moved = from_definition("old_msgs/Number", "int32 data")
    write(tmp_path / "x.bag", ("/a", 1, moved(data=7)))
    Path("moves").write_text(f"old_msgs/Number {moved._md5sum} std_msgs/Int32 {NEW._md5sum}\n")
    assert run("fix_moved_messages.py", "moves", "x.bag", "y.bag")[0] == 0
    assert content("y.bag") == [("/a", 1, "std_msgs/Int32", NEW._md5sum)]
    Path("moves").write_text("three words here\n")
    assert "moves:1: four words" in run("fix_moved_messages.py", "moves", "x.bag", "y.bag")[2]


@pytest.mark.parametrize("script", sorted(command._SCRIPTS))
def test_wrong_arguments(run: Run, script: str) -> None:
    code, _, err = run(script)
    assert (code, f"usage: {script}" in err.lower()) == (2, True)
