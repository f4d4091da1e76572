"""XML with line numbers, and hostile XML."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import LaunchError
from pyros1.launch.reading.document import parse_document

TEXT = '<launch>\n  <node a="1" b="2">\n    <param/>text &amp; more<!-- c --> end\n  </node>\n</launch>\n'


def test_tags_know_their_line_and_attributes_their_order() -> None:
    root = parse_document(TEXT, "f.launch")
    (node,) = root.children
    assert (root.tag, root.line, node.line, node.children[0].line) == ("launch", 1, 2, 3)
    assert list(node.attributes.items()) == [("a", "1"), ("b", "2")]
    assert node.text.strip() == "text & more end"
    assert str(node.error("bad")) == "f.launch:2: bad"


@pytest.mark.parametrize(
    "text", ["", "<foo/>", "<launch>", "<launch/><launch/>", "<launch><a></launch>", "x", "\0", "<launch a='1' a='2'/>"]
)
def test_bad_xml_x07(text: str) -> None:
    with pytest.raises(LaunchError, match=r"^f\.launch(:\d+)?: Invalid roslaunch XML syntax"):
        parse_document(text, "f.launch")


def test_entities_are_short_texts() -> None:
    text = '<!DOCTYPE l [<!ENTITY x "y">]><launch a="&x;1">&x;2</launch>'
    root = parse_document(text, "f.launch")
    assert (root.attributes, root.text) == ({"a": "y1"}, "y2")


def test_other_entities_are_refused() -> None:
    bomb = '<!DOCTYPE l [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]><launch>&b;</launch>'
    outside = '<!DOCTYPE l [<!ENTITY a SYSTEM "file:///etc/passwd">]><launch>&a;</launch>'
    markup = '<!DOCTYPE l [<!ENTITY a "<node/>">]><launch>&a;</launch>'
    long = f'<!DOCTYPE l [<!ENTITY a "{"x" * 1000}">]><launch>&a;</launch>'
    parameter = '<!DOCTYPE l [<!ENTITY % a "x">]><launch/>'
    many = "<!DOCTYPE l [" + "".join(f'<!ENTITY a{i} "x">' for i in range(1000)) + "]><launch/>"
    for text in (bomb, outside, markup, long, parameter, many):
        with pytest.raises(
            LaunchError, match=r"^f.launch:1: Invalid roslaunch XML syntax: the entity '\w+' is not allowed: "
        ):
            parse_document(text, "f.launch")
    with pytest.raises(LaunchError, match="deeply"):
        parse_document("<launch>" + "<a>" * 5000, "f.launch")


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b'<?xml version="1.0" encoding="nonsense"?><launch/>', "unknown encoding"),
        (
            b'<!DOCTYPE l [<!NOTATION n SYSTEM "n"><!ENTITY x SYSTEM "y" NDATA n>]><launch/>',
            "entity 'x' is not allowed",
        ),
        (
            b"<launch>\n<launch/></launch>",
            "f.launch:2: Invalid roslaunch XML syntax: there can be only one <launch> tag",
        ),
        (b"<a>\n<b/></a>", "f.launch:1: Invalid roslaunch XML syntax: no root <launch> tag"),
    ],
)
def test_documents_that_are_refused_say_why(data: bytes, said: str) -> None:
    with pytest.raises(LaunchError) as refusal:
        parse_document(data, "f.launch")
    assert said in str(refusal.value)


@given(st.binary(max_size=80) | st.integers(0, len(TEXT)).map(lambda end: TEXT[:end].encode()))
def test_any_bytes_give_a_tree_or_the_documented_error(data: bytes) -> None:
    with contextlib.suppress(LaunchError):
        assert parse_document(data, "f.launch").tag == "launch"
