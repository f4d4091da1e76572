"""Definitions of other sites' types: asked for once, and compared with their md5 sums."""

from __future__ import annotations

import pytest

from pyros1.bridge.exchange import definitions as module
from pyros1.bridge.exchange.definitions import Definitions, checked_text
from pyros1.bridge.protocol.packets import Definition
from pyros1.msgs import from_definition

TEXT = "float64 x\nstring name\n"
MD5 = from_definition("far_msgs/Thing", TEXT)._md5sum


def test_each_site_is_asked_once_at_a_time() -> None:
    definitions = Definitions()
    assert (
        definitions.take_requests("red", [MD5, MD5], 0.0, 9) == [MD5]
        and definitions.take_requests("red", [MD5], 1.0, 9) == []
    )
    assert definitions.text("far_msgs/Thing", MD5) is None and definitions.is_missing("red", "far_msgs/Thing", MD5)
    assert definitions.add("red", Definition("far_msgs/Thing", MD5, TEXT))
    assert definitions.text("far_msgs/Thing", MD5) == TEXT and not definitions.is_missing("red", "far_msgs/Thing", MD5)
    assert definitions.take_requests("red", [MD5], 5.0, 9) == [MD5]  # of another type with the same sum


def test_a_site_cannot_withhold_definitions_of_others() -> None:
    definitions = Definitions()
    assert definitions.take_requests("liar", [MD5], 0.0, 9) == [MD5] and definitions.take_requests(
        "red", [MD5], 0.0, 9
    ) == [MD5]
    assert definitions.add("red", Definition("far_msgs/Thing", MD5, TEXT))
    other = Definitions()
    other.take_requests("liar", [MD5], 0.0, 9)
    assert other.add("liar", Definition("far_msgs/Thing", MD5, ""))
    assert not other.is_missing("liar", "far_msgs/Thing", MD5) and other.is_missing("red", "far_msgs/Thing", MD5)
    other.take_requests("red", [MD5], 0.0, 9)
    assert not other.is_missing("red", "far_msgs/Thing", MD5), "it is asked only once"
    other.forget("red")
    assert other.is_missing("red", "far_msgs/Thing", MD5)


def test_what_is_remembered_is_bounded() -> None:
    definitions = Definitions()
    for number in range(100):
        definitions.take_requests("red", [f"{number}_{index}" for index in range(100)], float(number), 100)
    assert definitions.take_requests("red", ["99_0", "0_0"], 100.0, 9) == ["0_0"], "the oldest are forgotten"


def test_a_definition_that_can_be_used_is_not_replaced() -> None:
    definitions = Definitions()
    definitions.take_requests("red", [MD5], 0.0, 9)
    definitions.take_requests("blue", [MD5], 0.0, 9)
    assert definitions.add("red", Definition("far_msgs/Thing", MD5, ""))  # one site does not have it,
    assert not definitions.add("red", Definition("far_msgs/Thing", MD5, ""))
    assert definitions.add("blue", Definition("far_msgs/Thing", MD5, TEXT))  # but another one has
    for text in ("", "junk", TEXT + "# and a comment\n"):
        assert not definitions.add("red", Definition("far_msgs/Thing", MD5, text))
    assert definitions.text("far_msgs/Thing", MD5) == TEXT


def test_what_a_site_was_not_asked_for_is_ignored() -> None:
    definitions = Definitions()
    definitions.take_requests("blue", [MD5], 0.0, 9)
    assert not definitions.add("red", Definition("far_msgs/Thing", MD5, TEXT))
    assert definitions.text("far_msgs/Thing", MD5) is None


def test_a_text_that_does_not_belong_to_its_sum_is_not_used() -> None:
    assert checked_text(Definition("far_msgs/Thing", MD5, TEXT)) == TEXT
    assert checked_text(Definition("far_msgs/Thing", MD5, "float64 x\nstring lie\n")) == ""
    assert checked_text(Definition("far_msgs/Thing", MD5, "no definition at all")) == ""
    assert checked_text(Definition("far_msgs/Thing", MD5, "")) == ""
    assert checked_text(Definition("far_msgs/Thing", MD5, TEXT + "# \ud800\n")) == ""
    assert checked_text(Definition("far_msgs/Thing", MD5, "far_msgs/Thing x\n")) == ""


def thing(number: int) -> Definition:
    text = f"float64 x{number}\n"
    return Definition("far_msgs/Thing", from_definition("far_msgs/Thing", text)._md5sum, text)


def send(definitions: Definitions, site: str, *numbers: int) -> list[bool]:
    """Let a site be asked for definitions, and send them; return which of them are of use."""
    for number in numbers:
        definitions.take_requests(site, [thing(number).md5sum], 0.0, 9)
    return [definitions.add(site, thing(number)) for number in numbers]


def test_a_site_with_too_many_types_takes_no_room_from_others(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SITE_DEFINITIONS", 3)
    definitions = Definitions()
    assert send(definitions, "liar", 0, 1, 2, 3, 4) == [True, True, True, False, False]
    assert send(definitions, "red", 5, 6, 7) == [True, True, True]
    assert definitions.text("far_msgs/Thing", thing(2).md5sum) and definitions.text("far_msgs/Thing", thing(7).md5sum)


def test_the_texts_of_a_site_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SITE_CHARACTERS", 25)
    definitions = Definitions()
    assert len(thing(0).text) == 11 and send(definitions, "liar", 0, 1, 2) == [True, True, False]
    monkeypatch.setattr(module, "SITE_CHARACTERS", 1)
    assert send(definitions, "red", 3, 4) == [True, False]


def test_what_came_from_runs_that_have_ended_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SITE_DEFINITIONS", 3)
    definitions = Definitions()
    for number in range(0, 30, 3):
        assert send(definitions, "liar", number, number + 1, number + 2) == [True, True, True]
        assert definitions.text("far_msgs/Thing", thing(0).md5sum) == thing(0).text, "a topic of another site uses it"
        definitions.forget("liar")
    kept = [number for number in range(30) if definitions.text("far_msgs/Thing", thing(number).md5sum)]
    assert kept == [0, 28, 29], "those that were used last"
