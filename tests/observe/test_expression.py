"""Filter expressions: Python's syntax, nothing that could harm."""

from __future__ import annotations

import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.timing import Time
from pyros1.msgs.geometry_msgs.msg import PoseStamped
from pyros1.msgs.std_msgs.msg import String, UInt8MultiArray
from pyros1.observe.expression import Expression, ExpressionError, MessageLanguage


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


def test_expressions_of_recipes() -> None:
    message = PoseStamped()
    message.header.frame_id = "map"
    names = {"m": message, "t": Time(2, 500_000_000), "topic": "/pose"}
    for text in (
        "t.to_time() == t.to_sec() == 2.5",
        "m._type == 'geometry_msgs/PoseStamped'",
        "m._type.split('/')[1] in ('PoseStamped', 'Pose')",
        "m._has_header and 'header' in m.__slots__ and m._slot_types[0] == 'std_msgs/Header'",
        "len(m._md5sum) == 32 and 'pose' in m._full_text",
        "type(m).__name__ == 'PoseStamped' and type(m)._type == m._type and type(t).__name__ == 'Time'",
        "type(m.header.frame_id) == str",
        "getattr(m, '_type', '') and hasattr(m, '_type') and not hasattr(m.pose, 'header')",
        "m.pose.position.x.is_integer() and m.header.seq.bit_length() == 0",
        "max(*[1, 2], *(3, 4)) == 4 and [*range(2), 5] == [0, 1, 5] and {*'ab'} == {'a', 'b'}",
        "list(filter(lambda x: x > 1, [1, 2, 3])) == [2, 3]",
        "list(map(lambda x, y: x + y, [1, 2], [3, 4])) == [4, 6]",
        "sorted([1, 3, 2], key=lambda x: -x)[0] == 3 and min([1, -2], key=lambda x: abs(x)) == 1",
        "m.header.frame_id.encode().decode('utf-8') == 'map' and b' x '.strip() == b'x'",
    ):
        assert Expression(text)(names), text


@pytest.mark.parametrize(
    "text",
    [
        "m.__class__",
        "__import__('os')",
        "open('x')",
        "eval('1')",
        "(lambda: 1)()",
        "m._buff",
        "[x._check_types for x in [m]]",
        "m.__init__",
        "m.__name__",
        "m.header._type",
        "type(m).__init__",
        "type(m).__slots__.__class__",
        "type(m)._decode",
        "type(type(m))(1)",
        "type(m.data.encode())(9)",
        "str.__class__",
        "map(lambda x: x.__class__, [m])",
        "(lambda x: x)(m)",
        "[lambda: 1]",
        "map(lambda x, *y: x, [m])",
        "map(lambda x=m: x, [1])",
        "max([1], key=lambda: 1)",
        "dict(**{'a': 1})",
        "m.data.encode('punycode')",
        "m.data.encode().decode('idna')",
        "'{0.__class__}'.format(m)",
        "f'{m.__class__}'",
        "getattr(m, '__class__')",
        "getattr(m, '_decode', 5)",
        "getattr(m, 'serialize')",
        "hasattr(m, '_' + 'decode')",
        "getattr(getattr, 'func')",
        "str.join",
        "map.func",
        "math.os",
        "math.factorial(5)",
        "factorial(5)",
        "sorted([m], key=getattr)",
        "max([1], key=m.data.join)",
        "(m for m in [1]).gi_frame",
        "print(1)",
        "globals()",
        "vars(m)",
        "m.data.expandtabs(10 ** 9)",
        "m.data.translate({})",
        "'%s' % m.__dict__",
        "[x := 1]",
        "[y for x.data in [m]]",
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
    "text",
    [
        *("9 ** 9 ** 9", "1 << 99999", "'x' * 10 ** 9", "'%0999999999d' % 1", "m.serialize(1)", "m.nope"),
        *("pow(9, 10 ** 9)", "range(10 ** 9)", "list(range(10 ** 9))", "m.data * 10 ** 9", "'a'.zfill(10 ** 9)"),
        *(
            "f'{1:999999999}'",
            "f'{1:{10 ** 9}}'",
            "'{:999999999}'.format(1)",
            "format(1, '999999999')",
            "1000001 * [m]",
        ),
        *(
            "'x'.join(['y'] * 999999)",
            "('a' * 9999).replace('a', 'b' * 9999)",
            "[2 ** 4000] * 999999",
            "m.data.ljust(2 ** 40)",
        ),
        "str([2 ** 4000] * 999999)",
        "list(map(('ab' * 400000).join, ['xyz'] * 9))",
        "round(1, -999999999)",
        "int('9' * 999999)",
    ],
)
def test_an_operation_that_would_never_end_or_is_no_field_is_an_error(text: str) -> None:
    with pytest.raises(ExpressionError):
        Expression(text)({"m": String("x")})


@pytest.mark.parametrize(
    "text",
    [
        "[0 for a in range(9999) for b in range(9999)]",
        "any(0 for a in range(9999) for b in range(9999))",
        "sum(len(sorted(range(9999))) for a in range(999999))",
        "any(a in m.data for a in ['b'] * 900000)",
        "any((m.data + 'x' * 900000).count('y') for a in range(900000))",
        "any(len((m.data * 900000)[1:]) < 1 for a in range(900000))",
        "any(m.data * 900000 == m.data * 900001 for a in range(900000))",
        "[[[a for a in range(99)] for b in range(999)] for c in range(999)]",
        "min(sorted(range(900000)) for a in range(9999))",
        "any(t.isalpha() < 0 for t in ['x' * 900000] for a in range(9999))",
        "any(t.zfill(1) < 'a' for t in ['x' * 900000] for a in range(9999))",
        "any(t.count(-1) for t in [list(range(90000))] for a in range(9999))",
        # parts that are calculated again and again
        "[" + "a+" * 120 + "a for a in range(9999)]",
        "any((t and 0) for t in [1] for a in range(400000))",
        "any(-(2 ** 4095) > a for a in range(400000))",
        # what is deep inside
        "any(m == m for a in range(400000))",
        "any(str(m) == 1 for a in range(400000))",
        "any(f'{m!s:.0}' for a in range(400000))",
        "any([t] == 1 for t in [[[0] * 900] * 1000] for a in range(400000))",
        "any(t == u for t in [[[0] * 900] * 1000] for u in [[[0] * 900] * 1000 + [1]] for a in range(900))",
        "any(t in {1} for t in [((('x',) * 4900,) * 10,) * 5] for a in range(100000))",
        "any({1: 1}.get(t) for t in [((('x',) * 4900,) * 10,) * 5] for a in range(100000))",
        # every pair
        "('y' * 500000).strip('x' * 499999 + 'y')",
        "('x' * 900000).rfind('y' + 'x' * 90000)",
        "('y' + 'x' * 90000) in ('x' * 900000)",
        # functions that others call
        "any(map(lambda x: [x] * 9000, [1] * 9000))",
        "sorted([1] * 90000, key=lambda x: str(x) * 900)",
        "any(map(lambda x: map(lambda y: y + x, range(9000)), range(9000)))",
        "[*([0] * 900000), *([0] * 900000)]",
        "any(max(*[0] * 9000) for a in range(9000))",
        "any(map(('x' * 90000).count, ['y'] * 90000))",
        "filter(('x' * 90000).count, ['y'] * 90000)",
        "any(map(map, [sorted] * 900, [[list(range(9000))] * 9] * 900))",
        # the same again in every field
        "('{0!s:.0}' * 90000).format([0] * 9000)",
        "('%(a)s' * 9000) % {'a': 'x' * 90000}",
        # numbers that take long
        "any(math.lcm(2 ** 4095 - 1 - a, 2 ** 4095 - 3) == 3 for a in range(200000))",
        "any(math.fsum(t) for t in [[1e308, -1e308, 1e-300] * 9000] for a in range(200000))",
    ],
)
def test_work_that_piles_up_is_an_error(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setattr(MessageLanguage, "max_work", 300_000)
    with pytest.raises(ExpressionError, match=r"takes too much work|too many items|too large"):
        Expression(text)({"m": String("x")})


def test_each_character_of_a_message_that_is_shown_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(MessageLanguage, "max_work", 300_000)
    with pytest.raises(ExpressionError, match="takes too much work"):
        Expression("any(str(m) == 1 for a in range(3))")({"m": String("\x01" * 150_000)})


@pytest.mark.parametrize(
    "text",
    [
        "{n * (2 ** 61 - 1) for n in range(999)}",
        "{n * (2 ** 61 - 1): n for n in range(999)}",
        "set([n * (2 ** 61 - 1) for n in range(999)])",
        "dict([(n * (2 ** 61 - 1), n) for n in range(999)])",
        "set([1]).isdisjoint([(n * (2 ** 61 - 1), 2) for n in range(999)])",
    ],
)
def test_keys_of_one_hash_are_few(text: str) -> None:
    with pytest.raises(ExpressionError, match="too many keys have the same hash"):
        Expression(text)({"m": String("x")})
    few = text.replace("999", "99")
    Expression(few)({"m": String("x")})


def test_keys_may_be_many_and_equal() -> None:
    assert Expression("len({a % 7 for a in range(9999)}), len(set(range(9999))), dict(zip('ab', 'cd'))")({}) == (
        7,
        9999,
        {"a": "c", "b": "d"},
    )


def test_functions_that_call_themselves_end() -> None:
    text = "list(map(lambda f: map(f, [f]), dict(a=lambda g: map(g, [g])).values()))"
    with pytest.raises(ExpressionError):
        Expression(text)({})


@given(st.text(max_size=60))
def test_any_text_is_an_expression_or_the_documented_error(text: str) -> None:
    with contextlib.suppress(ExpressionError):
        Expression(text)({"m": String("x"), "topic": "/t"})


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("hasattr(m, 'header') and not hasattr(m, 'data')", True),
        ("hasattr(m.header, 'frame_' + 'id')", True),
        ("getattr(m, 'pose').position.x", 4.0),
        ("getattr(m, 'nope', None) is None", True),
        ("any(c == 'a' for c in m.header.frame_id)", True),
        ("all(len(w) == 3 for w in 'abc def'.split())", True),
        ("[c.upper() for c in m.header.frame_id if c != 'a']", ["M", "P"]),
        ("{c: i for i, c in enumerate('ab')}", {"a": 0, "b": 1}),
        ("{x % 2 for x in range(5)}", {0, 1}),
        ("sum(x ** 2 for x in [1, 2, 3]) / 3.0 > 4", True),
        ("f'{m.header.frame_id}:{m.pose.position.x:.2f}'", "map:4.00"),
        ("f'{m.header.frame_id!r:>8}'", "   'map'"),
        ("'{} at {:.1f}'.format(topic, m.header.stamp.to_sec())", "/t at 1.5"),
        ("'%s' % m.header.frame_id in ('map', 'odom')", True),
        ("m.header.frame_id[::-1].replace('p', 'b').title()", "Bam"),
        ("','.join(sorted(m.header.frame_id))", "a,m,p"),
        ("math.sqrt(m.pose.position.x) == sqrt(4) and math.pi == pi", True),
        ("math.hypot(m.pose.position.x, 3)", 5.0),
        ("round(m.pose.position.x / 3, 2)", 1.33),
        ("abs(min(-1, 2)) + max([1, 2], key=abs) + max([], default=3)", 6),
        ("sorted(['bb', 'a'], key=len, reverse=True)", ["bb", "a"]),
        ("sorted([10, 9], key=str) + [min([2, 1], key=None)]", [10, 9, 1]),
        ("dict(key='a')", {"key": "a"}),
        ("[a + b for a, b in zip([1, 2], [3, 4])]", [4, 6]),
        ("isinstance(topic, str) and str(1) == '1'", True),
        ("list(filter(None, map(int, '102')))", [1, 2]),
        ("dict(a=1).get('b', 2)", 2),
        ("bool({1, 2} & {2}) or b'x'.count(b'x')", True),
    ],
)
def test_what_people_write(text: str, value: object) -> None:
    message = PoseStamped()
    message.pose.position.x = 4.0
    message.header.frame_id = "map"
    message.header.stamp = Time(1, 500_000_000)
    names = {"m": message, "topic": "/t"}
    assert Expression(text)(names) == value
    assert eval(text, {"math": math, "sqrt": math.sqrt, "pi": math.pi, **names}) == value  # noqa: S307 - those above


@pytest.mark.slow
def test_a_large_message_can_be_looked_through() -> None:
    names = {"m": UInt8MultiArray(data=bytes(3_000_000))}
    assert Expression("max(m.data) == 0 and sum(m.data) == 0 and len(m.data) > 5 and 1 not in m.data")(names)
    names["m"].data = bytes(640 * 480)  # an image
    assert not Expression("sum(b > 50 for b in m.data) > 1")(names)
