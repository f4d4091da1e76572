"""Curves as commands take them, in the words of rqt_plot and of the page's plot."""

from __future__ import annotations

from pyros1.cli.invocation import Invocation
from pyros1.observe.fields import expand, split_expression


def curves_of(invocation: Invocation, word: str) -> list[str]:
    """Return the curves of an argument, with full names of topics.

    Args:
        invocation: the command's call.
        word: ``/topic/x:y``, ``/topic/array[0:3],/other/field``, or ``/topic: m.x * 2``.
    """
    found = []
    for text in expand(word):
        split = split_expression(text)
        found.append(f"{invocation.resolve(split[0])}: {split[1]}" if split else invocation.resolve(text))
    return found
