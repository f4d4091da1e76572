"""``topic type`` (L29)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.failures import UsageError, did_you_mean, fail
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the type of a topic or field."""
    if not args:
        raise UsageError("the following arguments are required: topic_or_field")
    if len(args) > 1:
        raise UsageError(f"unrecognized arguments: {' '.join(args[1:])}")
    name = invocation.resolve(args[0])
    graph = invocation.graph
    found = graph.find_topic(name)
    if found is None:
        fail(f"unknown topic type [{name}]{did_you_mean(name, graph.topic_types())}")
    _, topic_type, rest = found
    if not rest:
        print(topic_type)
        return
    from pyros1.ground.errors import MessageError  # noqa: PLC0415
    from pyros1.msgs import load_message  # noqa: PLC0415
    from pyros1.observe.fields import FieldPath, FieldPathError  # noqa: PLC0415 - needs the message classes

    try:
        field_type = FieldPath(rest).type_in(load_message(topic_type))
    except (FieldPathError, MessageError):
        fail(f"unknown topic type [{name}]")
    print(topic_type, rest.lstrip("/"), field_type)


VERB = Verb(
    "type",
    "print topic or field type",
    Argument("topic_or_field", "topic"),
    examples=[("/pose/header/stamp", "the type of a topic or field")],
    run=run,
)
