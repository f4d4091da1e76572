"""``topic_tools relay_field``: publishes messages whose fields are expressions of a received message (L193)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pyros1.cli.commands.topic_tools._expression import MessageExpression, names_used
from pyros1.cli.commands.topic_tools._transform import (
    TRANSFORM_ARGUMENTS,
    TRANSFORM_OPTIONS,
    Evaluator,
    parse_with_argparse,
    publish_evaluated,
)
from pyros1.cli.failures import CommandError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb
from pyros1.ground.timing import Time
from pyros1.msgs import Message
from pyros1.msgs.fill import fill_message
from pyros1.observe.expression import is_function
from pyros1.values import load_yaml


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Until the node shuts down, publish messages with fields computed by expressions."""
    publish_evaluated(
        invocation,
        "relay_field",
        options,
        lambda modules, output_class, node: make_field_evaluator(options.expression, modules, output_class, node.now),
    )


VERB = Verb(
    "relay_field",
    "for each message (available as m), publish a message with fields computed by Python expressions",
    *TRANSFORM_ARGUMENTS,
    Argument("expression", help="the output's fields as YAML"),
    *TRANSFORM_OPTIONS,
    usage="IN_TOPIC[/FIELD] OUT_TOPIC OUT_TYPE YAML",
    description="For each message, publishes a message whose fields are given as YAML. A string is evaluated if it\n"
    "is a Python expression that uses only known names. In expressions, m is the received message or its given\n"
    "field. Other strings are published unchanged.",
    examples=[("/chatter /header std_msgs/Header 'stamp: now\nframe_id: m.data'", "")],
    stock="rosrun topic_tools relay_field",
    parse=parse_with_argparse,
    run=run,
)


def make_field_evaluator(
    text: str, modules: Mapping[str, Any], output_class: type[Message], now: Callable[[], Time]
) -> Evaluator:
    """Return a function that creates the output message from an input message.

    Raises:
        CommandError: the fields are not valid YAML.
        ExpressionError: an expression uses something that is not allowed.
    """
    fields = _parse_fields(text, modules)

    def evaluate(message: Any) -> list[Any]:
        result = output_class()
        fill_message(result, _evaluate_fields(fields, {**modules, "m": message}), now())
        return [result]

    return evaluate


def _parse_fields(text: str, modules: Mapping[str, Any]) -> dict[str, Any]:
    """Parse the output's fields. Strings that are expressions become expression objects.

    Raises:
        CommandError: the string is not a YAML dictionary.
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
    """Return whether a string is a Python expression that uses only known names: m.data is one, base_link is not."""
    try:
        used_names = names_used(text)
    except (SyntaxError, ValueError):
        return False
    return used_names != {text.strip()} - {"m"} and all(
        name == "m" or name in modules or is_function(name) for name in used_names
    )


def _evaluate_fields(fields: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for name, value in fields.items():
        if isinstance(value, MessageExpression):
            result[name] = value.evaluate(values)
        else:
            result[name] = _evaluate_fields(value, values) if isinstance(value, dict) else value
    return result
