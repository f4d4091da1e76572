"""Prepares parameters for display and editing on a page (no I/O)."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from pyros1.values import YamlError, load_yaml
from pyros1.values.writing import dump

MAX_PARAMETERS = 20_000
"""Maximum number of parameters displayed."""
_MAX_TEXT_LENGTH = 300
"""Maximum number of characters displayed per value; the whole value is requested when the user edits it."""
_MAX_ITEMS = 60
_NON_FINITE_NUMBERS = {"nan": ".nan", "inf": ".inf", "-inf": "-.inf"}
_KIND_BY_TYPE = {str: "text", bool: "bool", int: "int", float: "double", list: "list", tuple: "list", dict: "dict"}


class ValueSummary(NamedTuple):
    """A parameter's value as displayed: its kind, the beginning of its text, and whether there is more."""

    kind: str
    text: str
    is_cut_off: bool


def flatten(tree: Any) -> Iterator[tuple[str, Any]]:
    """Yield the full name and value of each parameter in a tree; an empty dictionary counts as a value."""
    pending: list[tuple[str, Any]] = [("", tree)]
    while pending:
        name, value = pending.pop()
        if isinstance(value, dict) and (value or not name):
            pending.extend((f"{name}/{key!s}", child) for key, child in reversed(value.items()))
        else:
            yield name, value


def summarize(value: Any) -> ValueSummary:
    """Return the summary of a parameter's value."""
    kind = _KIND_BY_TYPE.get(value.__class__, "null" if value is None else "other")
    if isinstance(value, str):
        return ValueSummary(kind, value[:_MAX_TEXT_LENGTH], len(value) > _MAX_TEXT_LENGTH)
    if isinstance(value, float):
        return ValueSummary(kind, str(value) if math.isfinite(value) else _NON_FINITE_NUMBERS[str(value)], False)
    if isinstance(value, (bool, int)):
        return ValueSummary(kind, str(value).lower(), False)
    is_cut = isinstance(value, (list, tuple)) and len(value) > _MAX_ITEMS
    try:
        text = dump(value[:_MAX_ITEMS] if is_cut else value, is_inline=lambda _: True).removesuffix("...\n").strip()
    except YamlError:
        text = str(value)
    text = " ".join(text.split())
    return ValueSummary(kind, text[:_MAX_TEXT_LENGTH], is_cut or len(text) > _MAX_TEXT_LENGTH)


class Changes:
    """Finds what has changed in the parameters since a page's last update."""

    def __init__(self) -> None:
        self._known_summaries: dict[str, ValueSummary] | None = None
        self._last_repr = ""

    def update(self, tree: Any, may_see: Callable[[str], bool]) -> dict[str, Any] | None:
        """Return what has changed since the last update.

        Args:
            tree: all parameters.
            may_see: returns whether a parameter of this name may be displayed.

        Returns:
            ``all``: whether ``set`` contains all parameters, not only the changed ones; ``set``: name ->
            `ValueSummary`; ``gone``: names that were removed; ``more``: number of parameters that are omitted because
            there are too many. None if nothing has changed.
        """
        tree_repr = repr(tree)  # unlike ==, this distinguishes 1, 1.0 and true
        if self._known_summaries is not None and tree_repr == self._last_repr:
            return None
        self._last_repr = tree_repr
        visible = [(name, value) for name, value in flatten(tree) if may_see(name)]
        current = {name: summarize(value) for name, value in sorted(visible[:MAX_PARAMETERS], key=lambda pair: pair[0])}
        previous, self._known_summaries = self._known_summaries, current
        more = max(0, len(visible) - MAX_PARAMETERS)
        if previous is None:
            return {"all": True, "set": current, "gone": [], "more": more}
        changed = {name: value for name, value in current.items() if previous.get(name) != value}
        removed = [name for name in previous if name not in current]
        return {"all": False, "set": changed, "gone": removed, "more": more} if changed or removed else None


def editable_yaml(value: Any) -> str:
    """Return a value as YAML text for editing, with flat lists in brackets and multi-line strings as blocks.

    Raises:
        YamlError: see `pyros1.values.dump_yaml`.
    """

    if isinstance(value, str) and "\n" in value:
        text = _block_scalar(value)
        with contextlib.suppress(YamlError):
            if load_yaml(text) == value:
                return text

    def is_flat(part: Any) -> bool:
        items: Any = part.values() if isinstance(part, Mapping) else part
        return not any(isinstance(item, (list, dict)) for item in items)

    text = dump(value, is_inline=lambda part: isinstance(part, list) and is_flat(part), ordered=True)
    return text.removesuffix("...\n")


def _block_scalar(value: str) -> str:
    """Return a multi-line string as a YAML block scalar. Not every string survives the round trip."""
    chomping_indicator = (
        "-" if not value.endswith("\n") else "+" if value.endswith("\n\n") or not value.strip("\n") else ""
    )
    lines = value.removesuffix("\n").split("\n") if chomping_indicator != "-" else value.split("\n")
    # Without an indicator, YAML detects the indentation.
    indentation_indicator = "2" if lines[0].startswith((" ", "\t")) or not lines[0] else ""
    return f"|{indentation_indicator}{chomping_indicator}\n" + "".join(
        f"  {line}\n" if line else "\n" for line in lines
    )
