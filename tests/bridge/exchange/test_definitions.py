"""Definitions of other sites' types: asked for once, and compared with their md5 sums."""

from __future__ import annotations

from pyros1.bridge.exchange.definitions import Definitions, checked_text
from pyros1.bridge.protocol.packets import Definition
from pyros1.msgs import from_definition

TEXT = "float64 x\nstring name\n"
MD5 = from_definition("far_msgs/Thing", TEXT)._md5sum


def test_each_site_is_asked_once_at_a_time() -> None:
    definitions = Definitions()
    assert definitions.to_ask("red", [MD5, MD5], 0.0, 9) == [MD5] and definitions.to_ask("red", [MD5], 1.0, 9) == []
    assert definitions.text("far_msgs/Thing", MD5) is None and definitions.is_missing("red", "far_msgs/Thing", MD5)
    assert definitions.add("red", Definition("far_msgs/Thing", MD5, TEXT))
    assert definitions.text("far_msgs/Thing", MD5) == TEXT and not definitions.is_missing("red", "far_msgs/Thing", MD5)
    assert definitions.to_ask("red", [MD5], 5.0, 9) == [MD5]  # of another type with the same sum


def test_a_site_cannot_withhold_definitions_of_others() -> None:
    definitions = Definitions()
    assert definitions.to_ask("liar", [MD5], 0.0, 9) == [MD5] and definitions.to_ask("red", [MD5], 0.0, 9) == [MD5]
    assert definitions.add("red", Definition("far_msgs/Thing", MD5, TEXT))
    other = Definitions()
    other.to_ask("liar", [MD5], 0.0, 9)
    assert other.add("liar", Definition("far_msgs/Thing", MD5, ""))
    assert not other.is_missing("liar", "far_msgs/Thing", MD5) and other.is_missing("red", "far_msgs/Thing", MD5)
    other.to_ask("red", [MD5], 0.0, 9)
    assert not other.is_missing("red", "far_msgs/Thing", MD5), "it is asked only once"
    other.forget("red")
    assert other.is_missing("red", "far_msgs/Thing", MD5)


def test_what_is_remembered_is_bounded() -> None:
    definitions = Definitions()
    for number in range(100):
        definitions.to_ask("red", [f"{number}_{index}" for index in range(100)], float(number), 100)
    assert definitions.to_ask("red", ["99_0", "0_0"], 100.0, 9) == ["0_0"], "the oldest are forgotten"


def test_a_definition_that_can_be_used_is_not_replaced() -> None:
    definitions = Definitions()
    definitions.to_ask("red", [MD5], 0.0, 9)
    definitions.to_ask("blue", [MD5], 0.0, 9)
    assert definitions.add("red", Definition("far_msgs/Thing", MD5, ""))  # one site does not have it,
    assert not definitions.add("red", Definition("far_msgs/Thing", MD5, ""))
    assert definitions.add("blue", Definition("far_msgs/Thing", MD5, TEXT))  # but another one has
    for text in ("", "junk", TEXT + "# and a comment\n"):
        assert not definitions.add("red", Definition("far_msgs/Thing", MD5, text))
    assert definitions.text("far_msgs/Thing", MD5) == TEXT


def test_what_a_site_was_not_asked_for_is_ignored() -> None:
    definitions = Definitions()
    definitions.to_ask("blue", [MD5], 0.0, 9)
    assert not definitions.add("red", Definition("far_msgs/Thing", MD5, TEXT))
    assert definitions.text("far_msgs/Thing", MD5) is None


def test_a_text_that_does_not_belong_to_its_sum_is_not_used() -> None:
    assert checked_text(Definition("far_msgs/Thing", MD5, TEXT)) == TEXT
    assert checked_text(Definition("far_msgs/Thing", MD5, "float64 x\nstring lie\n")) == ""
    assert checked_text(Definition("far_msgs/Thing", MD5, "no definition at all")) == ""
    assert checked_text(Definition("far_msgs/Thing", MD5, "")) == ""
    assert checked_text(Definition("far_msgs/Thing", MD5, TEXT + "# \ud800\n")) == ""
    assert checked_text(Definition("far_msgs/Thing", MD5, "far_msgs/Thing x\n")) == ""
