"""Filter expressions: Python's syntax, nothing that could harm."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyros1.msgs.geometry_msgs.msg import PoseStamped
from pyros1.msgs.std_msgs.msg import String

from pyros1.cli.expression import Expression, ExpressionError
from pyros1.timing import Time


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("m.pose.position.x > 3", True),
        ("0 < m.pose.position.x < 3", False),
        ("m.header.frame_id == 'map' and not m.pose.position.y", True),
        ("abs(-2) + max(1, 2) ** 2 // 3", 3),
        ("m.header.frame_id.startswith('ma') or unknown", True),
        ("m.header.stamp.to_sec() >= 1.5", True),
        ("m.header.stamp.secs", 1),
        ("'x' in ['x', 'y'] if topic == '/t' else 0", True),
        ("len(m.header.frame_id[1:])", 2),
    ],
)
def test_expression_has_the_value_that_python_gives_it(text: str, value: object) -> None:
    message = PoseStamped()
    message.pose.position.x = 4.0
    message.header.frame_id = "map"
    message.header.stamp = Time(1, 500_000_000)
    assert Expression(text)({"m": message, "topic": "/t"}) == value


@pytest.mark.parametrize(
    "text",
    [
        "m.__class__",
        "m._type",
        "__import__('os')",
        "open('x')",
        "eval('1')",
        "(lambda: 1)()",
        "[x for x in m.data]",
        "m.data.format(1)",
        "f'{m}'",
        "m.data.startswith(x=1)",
        "(((",
        "",
        "x = 1",
        "a := 1",
        "*m",
    ],
)
def test_what_could_harm_is_refused(text: str) -> None:
    with pytest.raises(ExpressionError):
        Expression(text)({"m": String("x")})


@pytest.mark.parametrize(
    "text", ["9 ** 9 ** 9", "1 << 99999", "'x' * 10 ** 9", "'%0999999999d' % 1", "m.serialize(1)", "m.nope"]
)
def test_an_operation_that_would_never_end_or_is_no_field_is_an_error(text: str) -> None:
    with pytest.raises(ExpressionError):
        Expression(text)({"m": String("x")})


@given(st.text(max_size=60))
def test_any_text_is_an_expression_or_the_documented_error(text: str) -> None:
    with contextlib.suppress(ExpressionError):
        Expression(text)({"m": String("x"), "topic": "/t"})
