"""Curves in command arguments, in the syntax of rqt_plot and of the page's plot."""

from __future__ import annotations

from collections.abc import Iterable

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.graph import Graph
from pyros1.ground.errors import Error
from pyros1.observe.fields import FieldPath, expand, split_expression

_NO_NUMBERS = ("bool", "string", "time", "duration")


def curves_of(invocation: Invocation, word: str) -> list[str]:
    """Return the curves of an argument, with full names of topics.

    Args:
        invocation: the command's call.
        word: ``/topic/x:y``, ``/topic/array[0:3],/other/field``, or ``/topic: m.x * 2``.

    Raises:
        UsageError: there is a colon between fields, but no topic before them.
    """
    if not split_expression(word):
        for part in word.split(","):
            if ":" in part and "/" not in part.partition(":")[0]:
                raise UsageError(f"{part} must contain a topic and a field, as in /topic/x:y")
    found = []
    for text in expand(word):
        split = split_expression(text)
        found.append(f"{invocation.resolve(split[0])}: {split[1]}" if split else invocation.resolve(text))
    return found


def fields_of_messages(invocation: Invocation, curves: Iterable[str]) -> list[str]:
    """Return curves. As in rqt_plot, a message with several fields yields its numbers: ``/pose`` yields ``/pose/x`` ...

    Topics that the master does not know stay as they are, and so do all topics if it does not answer.

    Args:
        invocation: the command's call.
        curves: what `curves_of` returned.
    """
    try:
        graph = invocation.graph
        return [each for curve in curves for each in _numbers_in(graph, curve)]
    except Error:
        return [*curves]


def _numbers_in(graph: Graph, curve: str) -> list[str]:
    from pyros1.msgs import load_message  # noqa: PLC0415 - only needed for known topics

    found = None if split_expression(curve) else graph.find_topic(curve)
    if found is None:
        return [curve]
    _, kind, rest = found
    try:
        kind = FieldPath(rest).type_in(load_message(kind))
        cls = load_message(kind)
    except Error:  # not a message, or an unknown type: the page reports why it cannot be drawn
        return [curve]
    if len(cls.__slots__) == 1:  # the page draws it as it is
        return [curve]
    slots = zip(cls.__slots__, cls._slot_types, strict=True)
    numbers = [name for name, each in slots if "[" not in each and each not in (*_NO_NUMBERS, *cls._classes)]
    return [f"{curve.rstrip('/')}/{name}" for name in numbers] or [curve]
