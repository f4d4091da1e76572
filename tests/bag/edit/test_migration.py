"""bag check and bag fix: definitions that changed, rules, what needs none (L139, L140)."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import pyros1.bag
from pyros1.bag import BagWriter
from pyros1.bag.edit.migration import Migrator, rule_text
from pyros1.cli.running import run_command
from pyros1.msgs import from_definition, load_message

from ...bodies import encode
from ..conftest import Make
from ..made import header_of

OLD = from_definition("std_msgs/Int32", "int16 value")


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, call_main: Any, tmp_path: Path) -> Callable[..., tuple[int, str, str]]:
    monkeypatch.chdir(tmp_path)
    return partial(call_main, partial(run_command, "bag"))


@pytest.fixture
def old_bag(tmp_path: Path) -> Path:
    path = tmp_path / "old.bag"
    with BagWriter(path) as writer:
        conn = writer.add_connection("/a", header_of(OLD, callerid="/talker"))
        for i in range(3):
            writer.write(conn, i, encode(OLD(value=i)))
    return path


def test_nothing_to_do(run: Any, make_bag: Make) -> None:
    make_bag()
    assert run("check", "x.bag") == (0, "Bag file does not need any migrations.\n", "")
    assert run("fix", "x.bag", "y.bag") == (0, "Bag migrated successfully.\n", "")
    with pyros1.bag.open("y.bag") as bag:
        assert len(bag) == 100


def test_a_rule_is_made_finished_and_used(run: Any, old_bag: Path, tmp_path: Path) -> None:
    code, out, _ = run("check", "old.bag")
    assert code == 0
    assert f" * From: std_msgs/Int32 [{OLD._md5sum}]\n" in out
    assert "    1 rules missing:\n" in out
    code, out, _ = run("fix", "old.bag", "new.bag")
    assert (code, "could not be migrated" in out) == (1, True)
    assert not (tmp_path / "new.bag").exists()
    assert run("check", "old.bag", "-g", "rules.bmr")[0] == 0
    assert run("check", "old.bag", "-g", "rules.bmr")[0] == 2
    rules = tmp_path / "rules.bmr"
    text = rules.read_text()
    assert "valid = False" in text
    code, out, _ = run("fix", "old.bag", "new.bag", "rules.bmr")
    assert (code, "could not be migrated" in out) == (1, True), "it can be read, but is not valid"
    text = text.replace("valid = False", "valid = True")
    line = "# the old message has no int32 data: new_msg.data = ..."
    assert line in text
    rules.write_text(text.replace(line, "new_msg.data = old_msg.value + 10"))
    assert "All rules defined." in run("check", "old.bag", "rules.bmr")[1]
    assert run("fix", "old.bag", "new.bag", "rules.bmr") == (0, "Bag migrated successfully.\n", "")
    assert run("check", "new.bag")[1] == "Bag file does not need any migrations.\n"
    with pyros1.bag.open("new.bag") as bag:
        assert [item.message.data for item in bag.messages()] == [10, 11, 12]
        assert bag.connections[0].callerid == "/talker"


def test_a_rule_that_fails(run: Any, old_bag: Path, tmp_path: Path) -> None:
    assert run("check", "old.bag", "-g", "rules.bmr")[0] == 0
    text = (tmp_path / "rules.bmr").read_text().replace("valid = False", "valid = True")
    (tmp_path / "rules.bmr").write_text(text.replace("pass", "new_msg.data = old_msg.valeu"))
    code, _, err = run("fix", "old.bag", "new.bag", "rules.bmr")
    assert (code, "rules.bmr: the rule for std_msgs/Int32 failed: AttributeError" in err) == (1, True), err
    assert not (tmp_path / "new.bag").exists()
    code, _, err = run("fix", "old.bag", "new.bag", "old.bag")
    assert (code, "the rules cannot be used" in err) == (1, True), "a bag in the place of rules"


def test_a_definition_cannot_break_out_of_its_rule(tmp_path: Path) -> None:
    hostile = '# """; raise SystemExit(7) #\n# \\" \\n "\nint32 value\n'
    old, new = from_definition("p/A", hostile), from_definition("p/A", "int64 value\n")
    rules = tmp_path / "rules.bmr"
    rules.write_text(rule_text(old, new))
    migrator = Migrator(lambda name: new)
    migrator.read_rules(str(rules))
    assert [cls._full_text.strip() for cls, _ in migrator.missing_rules(old, new)] == [old._full_text.strip()]
    assert [(rule.old_class._md5sum, rule.valid) for rule in migrator.rules.values()] == [(old._md5sum, False)]


def test_fields_named_by_reserved_words_are_migrated(run: Any, tmp_path: Path) -> None:
    """Attributes have an underscore then (G10), in rules as everywhere: the rule needs nothing but the new field."""
    nested = "\n" + "=" * 80 + "\nMSG: p/Part\nint32 in\n"
    same = "float64 from\nstring lambda\np/Part None\np/Part[] self\n"
    old = from_definition("p/A", f"{same}int16 class{nested}")
    new = from_definition("p/A", f"{same}int32 def{nested}")
    rules = tmp_path / "rules.bmr"
    text = rule_text(old, new)
    line = "# the old message has no int32 def_: new_msg.def_ = ..."
    assert line in text and "# the new message has no field class_" in text
    rules.write_text(text.replace(line, "new_msg.def_ = old_msg.class_ * 2").replace("valid = False", "valid = True"))
    migrator = Migrator(lambda name: new)
    migrator.read_rules(str(rules))
    assert migrator.missing_rules(old, new) == []
    part = old().None_.__class__
    message: Any = old(from_=0.5, lambda_="l", None_=part(in_=3), self_=[part(in_=4), part(in_=5)], class_=21)
    done: Any = migrator.convert(message, new)
    found = (done.from_, done.lambda_, done.None_.in_, [each.in_ for each in done.self_], done.def_)
    assert (type(done), found) == (new, (0.5, "l", 3, [4, 5], 42))


def test_a_rule_for_a_definition_that_is_not_text(run: Any, tmp_path: Path) -> None:
    """Comments of old definitions are in any encoding; a NUL may be among them."""
    definition = b"int16 data  # 5 \xb0C, \xc2\xb0C, \0 end\nstring more"
    text = definition.decode("utf-8", "surrogateescape")
    old = from_definition("std_msgs/Int16", text)
    with BagWriter(tmp_path / "old.bag") as writer:
        header = {"type": b"std_msgs/Int16", "md5sum": old._md5sum.encode(), "message_definition": definition}
        writer.write(writer.add_connection("/a", header), 5, encode(old(data=7)))
    assert run("check", "old.bag", "-g", "rules.bmr")[0] == 0
    rules = tmp_path / "rules.bmr"
    rules.write_text(rules.read_text(encoding="utf-8").replace("valid = False", "valid = True"), encoding="utf-8")
    assert run("fix", "old.bag", "new.bag", "rules.bmr") == (0, "Bag migrated successfully.\n", "")
    with pyros1.bag.open("new.bag") as bag:
        assert [item.message.data for item in bag.messages()] == [7]


def test_force_leaves_what_it_cannot_migrate(run: Any, old_bag: Path) -> None:
    assert run("fix", "--force", "old.bag", "new.bag")[0] == 0
    with pyros1.bag.open("new.bag") as bag:
        assert [item.message.value for item in bag.messages()] == [0, 1, 2]


def test_changed_constants_need_no_rule(run: Any, tmp_path: Path) -> None:
    old = from_definition("std_msgs/String", "string data\nint8 OLD=1")
    with BagWriter(tmp_path / "old.bag") as writer:
        writer.write(writer.add_connection("/b", header_of(old)), 5, encode(old(data="x")))
    assert "All rules defined." in run("check", "old.bag")[1]
    assert run("fix", "old.bag", "new.bag")[0] == 0
    with pyros1.bag.open("new.bag") as bag:
        assert next(iter(bag.messages())).message.data == "x"
        assert bag.connections[0].md5sum == "992ce8a1687cec8c8bd883ec73ca41d1"


def test_a_type_that_nobody_knows(run: Any, tmp_path: Path) -> None:
    old = from_definition("nowhere_msgs/Thing", "int8 x")
    with BagWriter(tmp_path / "old.bag") as writer:
        writer.write(writer.add_connection("/b", header_of(old)), 5, b"\1")
    assert "To:   Unknown" in run("check", "old.bag")[1]


def test_wrong_words(run: Any, old_bag: Path, tmp_path: Path) -> None:
    assert run("check")[0] == 2
    assert run("fix", "old.bag")[0] == 2
    assert run("fix", "old.bag", "rules.bmr")[0] == 2
    assert run("check", "-a", "old.bag")[0] == 2
    (tmp_path / "bad.bmr").write_text("1 +")
    code, _, err = run("check", "old.bag", "bad.bmr")
    assert (code, "bad.bmr: the rules cannot be used: SyntaxError" in err) == (1, True)


def test_a_rule_names_types_with_or_without_their_package(tmp_path: Path) -> None:
    text = "Inner inner\nHeader header\n" + "=" * 80 + "\nMSG: some_msgs/Inner\nint32 a\n"
    (tmp_path / "rules.bmr").write_text(
        "class Rule(MessageUpdateRule):\n"
        "    old_type = new_type = 'some_msgs/Outer'\n"
        f"    old_full_text = {text!r}\n    new_full_text = 'int32 b'\n    valid = True\n"
    )
    migrator = Migrator(load_message)
    migrator.read_rules(str(tmp_path / "rules.bmr"))
    (rule,) = migrator.rules.values()
    for name in ("Inner", "some_msgs/Inner"):
        assert rule.get_old_class(name)(a=5).a == 5
    assert rule.get_old_class("Outer") is rule.old_class
    assert rule.get_new_class("some_msgs/Outer") is rule.new_class
    assert rule.get_old_class("Header")._type == "std_msgs/Header"
    for wanted in (rule.get_new_class, rule.get_old_class):
        with pytest.raises(KeyError, match="some_msgs/Other"):
            wanted("Other")
    with pytest.raises(KeyError):
        rule.get_new_class("Inner")
