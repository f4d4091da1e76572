"""``topic_tools relay_field`` (L193)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pyros1.cli.commands.topic_tools._expression import MessageExpression, names_used
from pyros1.cli.commands.topic_tools._transform import ARGUMENTS, OPTIONS, Evaluator, parse, publish
from pyros1.cli.failures import CommandError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb
from pyros1.ground.timing import Time
from pyros1.msgs import Message
from pyros1.msgs.fill import fill_message
from pyros1.observe.expression import is_function
from pyros1.values import load_yaml


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Publish messages whose fields are values of expressions, until the node ends."""
    publish(
        invocation,
        "relay_field",
        options,
        lambda modules, output_class, node: filler(options.expression, modules, output_class, node.now),
    )


VERB = Verb(
    "relay_field",
    "publish messages whose fields are expressions of the message m",
    *ARGUMENTS,
    Argument("expression", help="the output's fields, as YAML"),
    *OPTIONS,
    usage="IN_TOPIC[/FIELD] OUT_TOPIC OUT_TYPE YAML",
    description="Publishes a message whose fields are given as YAML. Strings that are\n"
    "expressions with known names are evaluated with m, a message of a topic, or a field of it.",
    examples=[("/chatter /header std_msgs/Header 'stamp: now\nframe_id: m.data'", "")],
    stock="rosrun topic_tools relay_field",
    parse=parse,
    run=run,
)


def filler(text: str, modules: Mapping[str, Any], output_class: type[Message], now: Callable[[], Time]) -> Evaluator:
    """Return a function that makes the output from a message.

    Raises:
        CommandError: the text is not YAML of fields.
        ExpressionError: an expression uses something that is not allowed.
    """
    fields = _fields(text, modules)

    def evaluate(message: Any) -> list[Any]:
        result = output_class()
        fill_message(result, _evaluated(fields, {**modules, "m": message}), now())
        return [result]

    return evaluate


def _fields(text: str, modules: Mapping[str, Any]) -> dict[str, Any]:
    """Return the output's fields, with strings that are expressions replaced by expression objects.

    Raises:
        CommandError: it is not YAML of fields.
        ExpressionError: an expression uses something that is not allowed.
    """
    fields = load_yaml(text)
    if not isinstance(fields, dict):
        raise CommandError(f"the output's fields must be given as YAML, such as 'data: m.data', not {text!r}")
    return _with_expressions(fields, modules)


def _with_expressions(fields: Mapping[str, Any], modules: Mapping[str, Any]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for name, value in fields.items():
        result[name] = value
        if isinstance(value, dict):
            result[name] = _with_expressions(value, modules)
        elif isinstance(value, str) and _is_expression(value, modules):
            result[name] = MessageExpression(value)
    return result


def _is_expression(text: str, modules: Mapping[str, Any]) -> bool:
    """Return whether a text is Python with known names only: m.data is, but base_link is the name of a frame."""
    try:
        used = names_used(text)
    except (SyntaxError, ValueError):
        return False
    return used != {text.strip()} - {"m"} and all(name == "m" or name in modules or is_function(name) for name in used)


def _evaluated(fields: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for name, value in fields.items():
        if isinstance(value, MessageExpression):
            result[name] = value.evaluate(values)
        else:
            result[name] = _evaluated(value, values) if isinstance(value, dict) else value
    return result
