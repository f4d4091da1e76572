"""``topic_tools transform``: publishes the value of an expression for each received message (L193)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyros1.cli.commands.topic_tools._expression import MessageExpression, names_used
from pyros1.cli.commands.topic_tools._transform import (
    TRANSFORM_ARGUMENTS,
    TRANSFORM_OPTIONS,
    Evaluator,
    parse_with_argparse,
    publish_evaluated,
)
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Publish the values of the expression until the node shuts down."""
    text = "m" if options.expression is None else options.expression
    publish_evaluated(invocation, "transform", options, lambda modules, *_: make_expression_evaluator(text, modules))


VERB = Verb(
    "transform",
    "evaluate a Python expression for each message (available as m) and publish the result",
    *TRANSFORM_ARGUMENTS,
    Argument("expression", optional=True, help="a Python expression in which m is the message (default: m itself)"),
    Option(
        "-i",
        "--import",
        dest="modules",
        nargs="+",
        default=[],
        help="modules that the expression uses: rospy, tf or message packages. math and numpy are always imported",
    ),
    Flag("--latch", help="latch the output"),
    *TRANSFORM_OPTIONS,
    usage="IN_TOPIC[/FIELD] OUT_TOPIC OUT_TYPE [EXPRESSION]",
    description="Evaluates an expression for each message, or for the given field of each message, and publishes\n"
    "the result. In the expression, m is the message or field. If the result is a list or tuple, its items are\n"
    "the values of the output message's fields, in order.",
    examples=[
        ("/imu/orientation/x /degrees std_msgs/Float64 -- '-numpy.rad2deg(m)'", ""),
        ("/imu/orientation /norm std_msgs/Float64 'numpy.linalg.norm([m.x, m.y, m.z, m.w])'", ""),
        ("/odom /pose geometry_msgs/PoseStamped '[m.header, m.pose.pose]'", ""),
    ],
    stock="rosrun topic_tools transform",
    parse=parse_with_argparse,
    run=run,
)


def make_expression_evaluator(text: str, modules: Mapping[str, Any]) -> Evaluator:
    """Return a function that computes the fields of the output from a message.

    Raises:
        ExpressionError: the expression is malformed or uses something that is not allowed.
    """
    expression = MessageExpression(text)
    for name in sorted(names_used(text) - {"m"}):
        expression.name(name, {**modules, "m": None})  # raise an error if the name is unknown

    def evaluate(message: Any) -> list[Any]:
        result = expression.evaluate({**modules, "m": message})
        return list(result) if isinstance(result, (list, tuple)) else [result]

    return evaluate
