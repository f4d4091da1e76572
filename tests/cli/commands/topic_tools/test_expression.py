"""What expressions of transform and relay_field can do, and what they cannot."""

from __future__ import annotations

import math
from typing import Any

import pytest

from pyros1.cli.commands.topic_tools._expression import MessageExpression, ModuleError, load_modules
from pyros1.cli.commands.topic_tools.relay_field import make_field_evaluator
from pyros1.cli.commands.topic_tools.transform import make_expression_evaluator
from pyros1.ground.expressions import ExpressionError
from pyros1.ground.timing import Time
from pyros1.msgs import Message, load_message


def now() -> Time:
    return Time(5, 6)


def modules(*names: str) -> dict[str, Any]:
    return load_modules(names, now)


def value(text: str, message: Any = None, *names: str) -> Any:
    return MessageExpression(text).evaluate({**modules(*names), "m": message})


def test_functions_and_comprehensions() -> None:
    scan: Any = load_message("sensor_msgs/LaserScan")(ranges=[0.0, 2.0, 1.0])
    assert value("min([r for r in m.ranges if r > 0])", scan) == 1.0
    assert value("[2 * i for i in range(3)]") == [0, 2, 4]
    assert value("'%.1f' % math.degrees(math.pi)") == "180.0"
    assert value("zip([1, 2], 'ab')") == [(1, "a"), (2, "b")]


def test_numpy() -> None:
    quaternion: Any = load_message("geometry_msgs/Quaternion")(0, 0, 3, 4)
    assert value("numpy.any(numpy.less(numpy.array([m.x, m.w]), 1))", quaternion) is True
    assert value("[numpy.argmax([m.z, m.w])]", quaternion) == [1]
    assert value("numpy.linalg.norm([m.x, m.y, m.z, m.w])", quaternion) == 5.0
    assert value("numpy.sum(numpy.array([m.z, m.w]) * 2).tolist()", quaternion) == 14.0


def test_arrays_of_other_shapes() -> None:
    odom: Any = load_message("nav_msgs/Odometry")()
    odom.pose.covariance = [float(number) for number in range(36)]
    assert value("numpy.array(m.pose.covariance).reshape(6, 6)[1, 0]", odom) == 6.0
    assert value("numpy.reshape(m.pose.covariance, (6, -1)).T.diagonal().tolist()", odom) == [0, 7, 14, 21, 28, 35]
    assert value("(numpy.eye(2) * numpy.full((2, 2), 3)).tolist()") == [[3, 0], [0, 3]]
    assert value("numpy.outer([1, 2], [3, 4]).tolist()") == [[3, 4], [6, 8]]
    assert value("numpy.dot(numpy.eye(2), [3, 4]).tolist() + [numpy.array([1, 2]).dot([3, 4])]") == [3, 4, 11]
    assert value("numpy.array([[1, 2], [3, 4]]).max(axis=0).clip(0, 3.5).astype(numpy.float32).tolist()") == [3, 3.5]
    assert value("numpy.arange(1, 4).tolist() + numpy.linspace(0, 1, 2).tolist()") == [1, 2, 3, 0, 1]
    assert value("numpy.tile([1, 2], 2).tolist() + numpy.repeat([1, 2], 2).tolist()") == [1, 2, 1, 2, 1, 1, 2, 2]


@pytest.mark.parametrize(
    "text",
    [
        "numpy.zeros(10 ** 9)",
        "numpy.ones((10 ** 5, 10 ** 5))",
        "numpy.full(shape=(10 ** 5, 10 ** 5), fill_value=1)",
        "numpy.eye(10 ** 5)",
        "numpy.identity(10 ** 5)",
        "numpy.arange(10 ** 12)",
        "numpy.arange(0, 1, 1e-12)",
        "numpy.arange(0, 1, 0)",
        "numpy.linspace(0, 1, 10 ** 9)",
        "numpy.linspace(0, 1, num=10 ** 9)",
        "numpy.outer(range(9999), range(9999))",
        "numpy.tile([1, 2], 10 ** 9)",
        "numpy.repeat([1, 2], 10 ** 9)",
        "numpy.arange(9999).reshape(-1, 1) * numpy.arange(9999)",
        "numpy.arange(9999).reshape(-1, 1) + list(range(9999))",
        "numpy.arange(9999)[:, numpy.newaxis] > numpy.arange(9999)",
        "numpy.array([2 ** 100])",
        "numpy.array([1], dtype='object')",
        "numpy.array([1]).astype('O')",
        "numpy.ndarray(5)",
        "numpy.empty(5)",
        "numpy.array([1]).tofile('x')",
        "numpy.array([1]).ctypes",
        "numpy.array([1]).dtype.names",
        "map(numpy.zeros, [10 ** 9])",
        "numpy.random.normal(0, 1, 10 ** 9)",
        "numpy.random.uniform(size=(10 ** 5, 10 ** 5))",
        "numpy.random.rand(10 ** 5, 10 ** 5)",
        "numpy.random.seed(1)",
        "numpy.dot([[i] for i in range(9999)], [list(range(9999))])",
        "numpy.add(numpy.arange(9999).reshape(-1, 1), numpy.arange(9999))",
        "numpy.where(numpy.arange(9999).reshape(-1, 1) > 0, numpy.arange(9999), 0)",
        "numpy.dot(numpy.arange(9999).reshape(-1, 1), numpy.arange(9999).reshape(1, -1))",
        "numpy.arange(9999).reshape(-1, 1).dot(numpy.arange(9999).reshape(1, -1))",
        "numpy.arange(9999).reshape(-1, 1).clip(numpy.arange(9999), 10000)",
        "map(numpy.add, [numpy.arange(9999).reshape(-1, 1)], [numpy.arange(9999)])",
    ],
)
def test_arrays_are_bounded(text: str) -> None:
    with pytest.raises(ExpressionError):
        value(text)


def test_recipes_with_transformations_and_lambdas() -> None:
    text = "geometry_msgs.msg.Vector3(*tf.transformations.euler_from_quaternion([0, 0, 0, 1]))"
    found: Any = value(text, None, "tf", "geometry_msgs")
    assert (found.x, found.y, found.z) == (0, 0, 0)
    assert value("map(lambda x: x * 2, tf.transformations.euler_from_quaternion([0, 0, 0, 1]))", None, "tf") == [
        0,
        0,
        0,
    ]
    assert value("sorted(['bb', 'a'], key=lambda word: len(word))") == ["a", "bb"]
    for text in ("rospy.Duration(secs=0, nsecs=5)", "rospy.rostime.Duration(nsecs=5)"):
        assert value(text, None, "rospy").to_nsec() == 5


def test_random_numbers_and_times() -> None:
    assert 0 <= value("random.random()", None, "random") <= 1 and value("random.choice([5])", None, "random") == 5
    assert abs(value("numpy.random.normal(m, 1e-9)", 2.0) - 2) < 1e-6
    assert value("len(numpy.random.uniform(0, 1, 3).tolist()) + len(numpy.random.rand(2, 2).tolist())") == 5
    assert value("time.time() > 1 and genpy.Time(1) < genpy.Time(2)", None, "time", "genpy") is True


def test_names_of_lambdas_and_comprehensions_need_no_import() -> None:
    text = "map(lambda x: x * 2 + m, [1, 2]), [y for y in [m]], sorted([2, 1], key=lambda a: -a)"
    assert make_expression_evaluator(text, modules())(3) == [[5, 7], [3], [2, 1]]


def test_whole_arrays() -> None:
    assert value("numpy.array([1, 5, 9])[numpy.array([1, 5, 9]) > 4].tolist()") == [5, 9]
    assert value("(True and numpy.array([1, 2]) == 2).tolist()") == [False, True]
    assert value("1 < 2 < 3 and not 3 < 2 < 9") is True


def test_messages_and_times() -> None:
    stamped: Any = value("geometry_msgs.msg.Point(x=m, y=2)", 1, "geometry_msgs")
    assert (stamped.x, stamped.y) == (1, 2)
    assert value("std_msgs.msg.Header(1, rospy.Time.now(), 'a')", None, "rospy", "std_msgs").stamp == now()
    assert value("sensor_msgs.msg.Range.INFRARED", None, "sensor_msgs") == 1


@pytest.mark.parametrize(
    "angles", [(0.1, -0.2, 0.3), (3.0, 1.0, -3.0), (0.0, math.pi / 2, 0.0), (0.4, math.pi / 2, 0.0)]
)
def test_transformations(angles: tuple[float, float, float]) -> None:
    text = f"tf.transformations.euler_from_quaternion(tf.transformations.quaternion_from_euler{angles})"
    assert value(text, None, "tf.transformations") == pytest.approx(angles, abs=1e-7)


@pytest.mark.parametrize(
    "text",
    [
        "m.__class__",
        "numpy.load('/etc/passwd')",
        "numpy.lib",
        "open('/etc/passwd')",
        "(lambda: 1)()",
        "range(10 ** 9)",
        "math.factorial(10 ** 6)",
        "str.format",
        "rospy.Time",
        "next([])",
        "numpy.histogram([0, 1e300, 1e-300], 'auto')",
    ],
)
def test_nothing_else_can_be_reached(text: str) -> None:
    with pytest.raises(ExpressionError):
        value(text, load_message("std_msgs/String")())


def test_other_modules_are_refused() -> None:
    with pytest.raises(ModuleError, match="cannot import 'os'"):
        modules("os")


def test_a_wrong_expression_is_refused_at_once() -> None:
    with pytest.raises(ExpressionError, match="unknown name 'x'"):
        make_expression_evaluator("x + m", modules())
    with pytest.raises(ExpressionError, match="not an expression"):
        make_expression_evaluator("m +", modules())


def test_a_list_stands_for_the_fields() -> None:
    assert make_expression_evaluator("[m, 2]", modules())(1) == [1, 2]
    assert make_expression_evaluator("m", modules())("text") == ["text"]


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ("{seq: 3, stamp: {secs: 1, nsecs: 2}, frame_id: m.data}", (3, Time(1, 2), "here")),
        ("frame_id: base_link", (0, Time(), "base_link")),
        ("frame_id: base/link", (0, Time(), "base/link")),
        ("frame_id: map", (0, Time(), "map")),
        ("frame_id: max", (0, Time(), "max")),
        ("{stamp: now, frame_id: m.data + '!'}", (0, now(), "here!")),
        ("seq: len(m.data)", (4, Time(), "")),
    ],
)
def test_fields_are_texts_or_expressions(fields: str, expected: tuple[int, Time, str]) -> None:
    header: type[Message] = load_message("std_msgs/Header")
    made: Any
    (made,) = make_field_evaluator(fields, modules(), header, now)(load_message("std_msgs/String")("here"))
    assert (made.seq, made.stamp, made.frame_id) == expected
