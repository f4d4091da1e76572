"""Parses the curves named in arguments, which have the same syntax as in rqt_plot and the web page's plot."""

from __future__ import annotations

from collections.abc import Iterable

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.graph import Graph
from pyros1.ground.errors import Error
from pyros1.observe.fields import FieldPath, expand_fields, split_expression

_NON_NUMERIC_TYPES = ("bool", "string", "time", "duration")


def parse_curves(invocation: Invocation, argument: str) -> list[str]:
    """Return the curves that an argument describes, with the full names of their topics.

    Args:
        invocation: the command's invocation.
        argument: ``/topic/x:y``, ``/topic/array[0:3],/other/field``, or ``/topic: m.x * 2``.

    Raises:
        UsageError: the argument has fields separated by colons, but no topic before them.
    """
    if not split_expression(argument):
        for part in argument.split(","):
            if ":" in part and "/" not in part.partition(":")[0]:
                raise UsageError(f"{part} must contain a topic and a field, as in /topic/x:y")
    curves = []
    for text in expand_fields(argument):
        topic_and_code = split_expression(text)
        curves.append(
            f"{invocation.resolve(topic_and_code[0])}: {topic_and_code[1]}"
            if topic_and_code
            else invocation.resolve(text)
        )
    return curves


def expand_messages(invocation: Invocation, curves: Iterable[str]) -> list[str]:
    """Replace curves that name whole messages with their numeric fields, as in rqt_plot: ``/pose`` with ``/pose/x`` ...

    Curves from unknown topics are kept unchanged, as are all curves if the master does not respond.

    Args:
        invocation: the command's invocation.
        curves: the result of `parse_curves`.
    """
    try:
        graph = invocation.graph
        return [field for curve in curves for field in _numeric_fields(graph, curve)]
    except Error:
        return [*curves]


def _numeric_fields(graph: Graph, curve: str) -> list[str]:
    from pyros1.msgs import load_message  # noqa: PLC0415 - only needed for known topics

    topic_match = None if split_expression(curve) else graph.find_topic(curve)
    if topic_match is None:
        return [curve]
    _, type_name, path = topic_match
    try:
        type_name = FieldPath(path).type_in(load_message(type_name))
        message_class = load_message(type_name)
    except Error:  # the page reports unknown types, and fields that are not messages
        return [curve]
    if len(message_class.__slots__) == 1:  # the page draws messages with a single field
        return [curve]
    slots = zip(message_class.__slots__, message_class._slot_types, strict=True)
    excluded_types = (*_NON_NUMERIC_TYPES, *message_class._classes)
    names = [name for name, slot_type in slots if "[" not in slot_type and slot_type not in excluded_types]
    return [f"{curve.rstrip('/')}/{name}" for name in names] or [curve]
