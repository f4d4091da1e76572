"""Definitions of other sites' types: asked for once, and compared with their md5 sums."""

from __future__ import annotations

from pyros1.bridge.exchange.definitions import Definitions, checked_text
from pyros1.bridge.protocol.packets import Definition
from pyros1.msgs import from_definition

TEXT = "float64 x\nstring name\n"
MD5 = from_definition("far_msgs/Thing", TEXT)._md5sum


def test_each_is_asked_for_once() -> None:
    definitions = Definitions()
    assert definitions.to_ask([MD5, MD5], 0.0, 9) == [MD5] and definitions.to_ask([MD5], 1.0, 9) == []
    assert definitions.text("far_msgs/Thing", MD5) is None
    assert definitions.add(Definition("far_msgs/Thing", MD5, TEXT))
    assert definitions.text("far_msgs/Thing", MD5) == TEXT
    assert definitions.to_ask([MD5], 5.0, 9) == [MD5]  # of another type with the same sum


def test_a_definition_that_can_be_used_is_not_replaced() -> None:
    definitions = Definitions()
    definitions.to_ask([MD5], 0.0, 9)
    assert definitions.add(Definition("far_msgs/Thing", MD5, ""))  # one site does not have it,
    assert not definitions.add(Definition("far_msgs/Thing", MD5, ""))
    assert definitions.add(Definition("far_msgs/Thing", MD5, TEXT))  # but another one has
    for text in ("", "junk", TEXT + "# and a comment\n"):
        assert not definitions.add(Definition("far_msgs/Thing", MD5, text))
    assert definitions.text("far_msgs/Thing", MD5) == TEXT


def test_what_nobody_asked_for_is_ignored() -> None:
    definitions = Definitions()
    assert not definitions.add(Definition("far_msgs/Thing", MD5, TEXT))
    assert definitions.text("far_msgs/Thing", MD5) is None


def test_a_text_that_does_not_belong_to_its_sum_is_not_used() -> None:
    assert checked_text(Definition("far_msgs/Thing", MD5, TEXT)) == TEXT
    assert checked_text(Definition("far_msgs/Thing", MD5, "float64 x\nstring lie\n")) == ""
    assert checked_text(Definition("far_msgs/Thing", MD5, "no definition at all")) == ""
    assert checked_text(Definition("far_msgs/Thing", MD5, "")) == ""
    assert checked_text(Definition("far_msgs/Thing", MD5, TEXT + "# \ud800\n")) == ""
    assert checked_text(Definition("far_msgs/Thing", MD5, "far_msgs/Thing x\n")) == ""
