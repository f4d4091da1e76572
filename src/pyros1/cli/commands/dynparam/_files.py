"""Configurations of dynamic_reconfigure as YAML files (L200)."""

from __future__ import annotations

import re
from typing import Any

from pyros1.ground.terminal_text import one_line
from pyros1.reconfigure.values import ParameterError
from pyros1.values import YamlError, dump_yaml, load_all_yaml

_TAG = "!!python/object/new:dynamic_reconfigure.encoding.Config"
"""The tag that stock writes before each mapping of a file. Only Python with that package can read the tag as YAML."""


def file_text(values: dict[str, Any]) -> str:
    """Return a configuration as the stock tool writes it, so that each can load the other's files."""
    lines = dump_yaml(_wrapped(values)).splitlines()
    for number, line in enumerate(lines[:-1]):
        below = lines[number + 1].strip()
        if line.endswith(":") and below in ("dictitems:", "state: []") and line.strip() != "dictitems:":
            lines[number] = f"{line} {_TAG}"
    return "\n".join([_TAG, *lines, ""])


def _wrapped(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    inside = {"dictitems": {key: _wrapped(each) for key, each in value.items()}} if value else {}
    return {**inside, "state": []}


def read_file_text(text: str, where: str) -> dict[str, Any]:
    """Return the values in a file from `file_text`, or in plain YAML. Several documents are merged.

    Args:
        text: the file's text.
        where: the file's name, for errors.

    Raises:
        ParameterError: the text is not a configuration.
    """
    values: dict[str, Any] = {}
    try:
        documents = load_all_yaml(re.sub(re.escape(_TAG) + r"[ \t]*$", "", text, flags=re.MULTILINE), where)
    except YamlError as error:
        raise ParameterError(str(error)) from None
    for document in documents:
        if not isinstance(document, dict):
            raise ParameterError(f"{where}: expected a dictionary of parameters, not {one_line(document, 60)!r}")
        values.update(_unwrapped(document))
    return values


def _unwrapped(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    if value.keys() <= {"dictitems", "state"} and value.get("state") == []:
        value = value.get("dictitems") or {}
    return {key: _unwrapped(each) for key, each in value.items()}
