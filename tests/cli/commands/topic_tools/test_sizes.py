"""No expression with arrays takes much memory or time, whatever its functions and arguments."""

from __future__ import annotations

import contextlib
import random
import tracemalloc
import warnings
from typing import Any

import pytest

from pyros1.cli.commands.topic_tools._arrays import ARRAY_MEMBERS, numpy_module
from pyros1.cli.commands.topic_tools._expression import MessageExpression, load_modules
from pyros1.ground.expressions import ExpressionError
from pyros1.ground.timing import Time
from pyros1.observe.expression import FUNCTIONS

pytestmark = pytest.mark.once

MODULES = load_modules(["tf", "random", "rospy", "std_msgs"], Time)
MOST = 200_000_000
"""Bytes."""


def value(text: str) -> Any:
    return MessageExpression(text).evaluate({**MODULES, "m": 1.5})


def peak(text: str) -> int:
    """Return the memory that an expression takes at most, in bytes; it may fail, but only with the documented error."""
    tracemalloc.start()
    try:
        with contextlib.suppress(ExpressionError):
            value(text)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        # many arrays
        "[numpy.ones(500000) + 1 for x in range(1000)]",
        "sum([numpy.ones(500000)] * 100000)",
        f"[{'numpy.ones(10 ** 6), ' * 300}]",
        "map(lambda a: [a.copy() for x in range(1000)], [numpy.ones(10 ** 5)])",
        "map(lambda a: [a > 0 for x in range(10 ** 6)], [numpy.ones(10 ** 5)])",
        # large results
        "numpy.diag(numpy.zeros(90000))",
        "numpy.diag([1], k=10 ** 6)",
        "numpy.full_like([1], 2, shape=(10 ** 6, 10 ** 6))",
        "numpy.zeros_like([1], shape=10 ** 9)",
        "numpy.zeros_like([1], float, 'C', True, 10 ** 9)",
        "numpy.linspace(numpy.zeros(10 ** 4), 1, 10 ** 5)",
        "numpy.percentile(numpy.zeros((1, 10 ** 5)), numpy.zeros(10 ** 4), axis=0)",
        "numpy.zeros((1000, 1000))[[0] * 10 ** 5]",
        "numpy.zeros((1000, 1000))[numpy.zeros((1000, 1), 'i8'), numpy.zeros(10 ** 4, 'i8')]",
        "numpy.zeros((10 ** 4, 1)) + [[0] * 10 ** 4]",
        "numpy.repeat([1, 2], [10 ** 9, 10 ** 9])",
        "numpy.random.normal(numpy.zeros((10 ** 5, 1)), numpy.ones(10 ** 5))",
        "numpy.nonzero(numpy.ones(10 ** 6).reshape((1,) * 30 + (10 ** 6,)))",
        "tf.transformations.projection_matrix([0] * 10 ** 4, [1] * 10 ** 4)",
        "numpy.insert(numpy.zeros((1000, 1000)), [0] * 10 ** 5, 0, axis=0)",
        "numpy.histogram([1, 2], 10 ** 9)",
        "numpy.split(numpy.zeros(10 ** 6), 10 ** 6)",
        "numpy.inner(numpy.zeros((10 ** 4, 1)), numpy.zeros((10 ** 4, 1)))",
        "numpy.matmul(numpy.ones((10 ** 5, 1)), numpy.ones((1, 10 ** 5)))",
        "numpy.ones((10 ** 5, 1)) @ numpy.ones((1, 10 ** 5))",
        "bytes(10 ** 9)",
        "bytearray(numpy.int64(10 ** 9))",
        "pow(2, 10 ** 9)",
        # wide items
        "numpy.zeros(3, 'U100000000')",
        "numpy.zeros(3, dtype=b'U100000000')",
        "numpy.ones_like(1, 'U1000000')",
        "numpy.zeros(3, ('f8', (10 ** 8,)))",
        "numpy.zeros(3, [('a', 'f8', (10 ** 8,))])",
        "numpy.array(['a' * 100000] + ['b'] * 1000)",
        "numpy.full(1000, 'a' * 100000)",
        "numpy.array(['a' * 1000] * 1000) + numpy.array(['b' * 100000])",
        # functions of Python that combine arrays
        "sum([numpy.zeros((50000, 1)), numpy.zeros(50000)])",
        "max(numpy.zeros((50000, 1)), numpy.zeros(50000))",
        "divmod(numpy.ones((50000, 1)), numpy.ones(50000))",
        "random.uniform(numpy.ones((50000, 1)), numpy.ones(50000))",
        "[numpy.zeros((50000, 1))].index(numpy.zeros(50000))",
        "numpy.zeros((50000, 1)) in [numpy.zeros(50000)]",
        "[numpy.zeros((50000, 1))] == [numpy.zeros(50000)]",
        "{1: numpy.zeros((50000, 1))} == {1: numpy.zeros(50000)}",
        "numpy.zeros((50000, 1)) in {1: numpy.zeros(50000)}.values()",
        "map(lambda c: c(data=numpy.ones((50000, 1))) == c(data=numpy.ones(50000)), [std_msgs.msg.ByteMultiArray])",
        "sorted([1, 2], key=lambda x: numpy.zeros((50000, 1)) if x > 1 else numpy.zeros(50000))",
        # Python's objects and numpy's integers
        "numpy.power(2 ** 4000, 10 ** 6)",
        "numpy.power([3], 10 ** 9, dtype='O')",
        "numpy.array([5]) ** [10 ** 30]",
        "numpy.int64(5) ** [10 ** 30]",
        "numpy.multiply(['a' * 10000, None], 10 ** 6)",
        "numpy.int64(10 ** 9) * 'ab'",
        "'ab' * numpy.int64(10 ** 9)",
        "(1,) * numpy.int64(10 ** 9)",
        # work
        "numpy.convolve(numpy.ones(10 ** 5), numpy.ones(10 ** 5))",
        "numpy.matmul(numpy.ones((1000, 1000), int), numpy.ones((1000, 1000), int))",
        "numpy.ones((1000, 1000), int) @ numpy.ones((1000, 1000), int)",
        "numpy.inner(numpy.ones((1000, 1000), int), numpy.ones((1000, 1000), int))",
        "numpy.polyfit(range(9999), range(9999), 5000)",
        "numpy.polyval(numpy.ones(10 ** 6), numpy.ones(10 ** 6))",
        "numpy.around([1.5], 2 ** 31 - 1)",
        "numpy.float64(1).round(2 ** 31 - 1)",
        "numpy.diff([1], 10 ** 9)",
        "numpy.nanpercentile(numpy.zeros((10 ** 5, 1)), 50, axis=1)",
        "numpy.linalg.eigvals(numpy.random.rand(1000, 1000))",
        "numpy.dot(numpy.ones((1000, 1000), int), numpy.ones((1000, 1000), int))",
        "[x in numpy.ones(10 ** 6) for x in range(10 ** 4)]",
    ],
    ids=lambda text: text[:40],
)  # fmt: skip
def test_too_large(text: str) -> None:
    assert peak(text) < MOST
    with pytest.raises(ExpressionError, match=r"too large|too much|can only|dimensions|most 32|named|digits|sorted by"):
        value(text)


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        "[x " + "for x in [1, 2] " * 300 + "]",
        "[str(numpy.ones(999)) for x in range(10 ** 5)]",
        "['%s' % numpy.ones(999) for x in range(10 ** 5)]",
        "[f'{numpy.ones(999)}' for x in range(10 ** 5)]",
    ],
    ids=lambda text: text[:40],
)
def test_too_slow(text: str) -> None:
    with pytest.raises(ExpressionError, match="too much"):
        value(text)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("numpy.random.normal(loc=0, scale=1, size=3).shape", (3,)),
        ("pow(m, 2) + next(x for x in [1, 2]) + next([], 3)", 6.25),
        ("(numpy.eye(2) @ numpy.array([[1], [2]])).tolist()", [[1], [2]]),
        ("bytes(bytearray([1, 2])) + numpy.array([3], 'u1').tobytes()", b"\1\2\3"),
        ("numpy.matmul(numpy.ones((5, 2, 3)), numpy.ones((3, 4))).shape", (5, 2, 4)),
        ("numpy.inner([1, 2], [3, 4]) + numpy.vdot([1, 2], [3, 4])", 22),
        ("numpy.histogram([1, 2, 2], bins=2)[0].tolist()", [1, 2]),
        ("numpy.split(numpy.arange(4), 2)[1].tolist() + numpy.insert([1], 0, 2).tolist()", [2, 3, 2, 1]),
        ("numpy.eye(N=2, dtype=int).tolist()", [[1, 0], [0, 1]]),
        ("numpy.repeat([1, 2], [1, 2]).tolist()", [1, 2, 2]),
        ("numpy.ones((300, 300))[:, [0, 1] * 100].shape", (300, 200)),
        ("numpy.arange(9).reshape(3, 3)[..., [0, 2]].tolist()", [[0, 2], [3, 5], [6, 8]]),
        ("numpy.arange(9).reshape(3, 3)[numpy.eye(3) > 0].tolist()", [0, 4, 8]),
        ("numpy.arange(4)[None, :, numpy.newaxis].shape", (1, 4, 1)),
        ("numpy.linalg.lstsq(numpy.ones((5000, 2)), numpy.ones(5000), rcond=None)[2]", 1),
        ("numpy.polyfit(range(100), range(100), 1).round(6).tolist()", [1, 0]),
        ("numpy.frombuffer(b'ab' * 300000, numpy.uint8).reshape(-1, 3).mean(axis=1).max()", 293 / 3),
        ("sum([numpy.ones(3)] * 4).tolist()", [4, 4, 4]),
        ("sorted([(numpy.float64(2), 'b'), (numpy.float64(1), 'a')])[0][1]", "a"),
        ("2 * numpy.int64(3) in {6: 1}", True),
        ("numpy.array(['a', 'bc']).tolist()", ["a", "bc"]),
        ("rospy.Duration(1) * numpy.float64(2) == rospy.Duration(2)", True),
    ],
)
def test_harmless(text: str, expected: Any) -> None:
    result = value(text)
    assert (pytest.approx(result) == expected) if isinstance(expected, float) else result == expected


LEAVES = """
0 1 2 -1 10**4 10**6 10**9 2**63 2**70 1e300 1e-9 m float('nan') None True 'a' 'ab'*30000 b'ab'*5000 'U1000000' 'f8'
'O' numpy.float64 numpy.int64(10**9) numpy.uint8(3) (3,4) (10**5,10**5) (2,)*18 [0]*10**4 range(10**5) [[1]]*10**4
['a'*10**4,'b'] [None] [2**100] [numpy.ones(3)]*1000 numpy.ones(10**6) numpy.zeros((1000,1000),int) {1:2} set([1,2])
numpy.ones((10**5,1),'u1') numpy.random.rand(300,300) numpy.array(['a'*1000]*1000) rospy.Time(1,2)
std_msgs.msg.Float64MultiArray(data=numpy.ones(10**4))
"""
KEYWORDS = ["axis", "dtype", "shape", "n", "k", "decimals", "size", "out", "prepend", "order", "deg", "num", "ord"]
OPERATORS = ["+", "-", "*", "/", "//", "%", "**", "<<", "&", "|", "<", "==", "in"]


def functions() -> list[str]:
    modules = {"numpy": numpy_module(), "tf.transformations": MODULES["tf"].get("transformations")}
    modules |= {f"numpy.{name}": modules["numpy"].get(name) for name in ("linalg", "random")}
    found = [f"{module}.{name}" for module, members in modules.items() for name in members.names]
    return found + 3 * [*FUNCTIONS, "random.uniform", "random.choice", "rospy.Time", "math.dist"]


def expression(source: random.Random, names: list[str], depth: int) -> str:
    """Return an expression with arguments that are likely to be hostile."""

    def part() -> str:
        return expression(source, names, depth - 1)

    kind = source.random()
    if depth == 0 or kind < 0.3:
        return source.choice(LEAVES.split())
    if kind < 0.65:
        arguments = [part() for _ in range(source.randint(1, 3))]
        arguments += [
            f"{name}={source.choice(LEAVES.split())}" for name in source.sample(KEYWORDS, source.choice([0, 0, 1]))
        ]
        return f"{source.choice(names)}({', '.join(arguments)})"
    if kind < 0.75:
        return f"({part()}).{source.choice(sorted(ARRAY_MEMBERS))}({source.choice(['', part()])})"
    if kind < 0.9:
        return f"({part()} {source.choice(OPERATORS)} {part()})"
    return source.choice(
        [f"[{part()} for x in {part()}]", f"map(lambda a: {part()}, {part()})", f"({part()})[{part()}, {part()}]"]
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_random_expressions(seed: int) -> None:
    source, names = random.Random(seed), functions()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for _ in range(25):
            text = expression(source, names, source.randint(1, 3))
            assert peak(text) < MOST, text
