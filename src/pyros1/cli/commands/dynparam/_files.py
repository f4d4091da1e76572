"""Converts dynamic_reconfigure configurations to and from YAML files (L200)."""

from __future__ import annotations

import re
from typing import Any

from pyros1.ground.terminal_text import one_line
from pyros1.reconfigure.values import ParameterError
from pyros1.values import YamlError, dump_yaml, load_all_yaml

_TAG = "!!python/object/new:dynamic_reconfigure.encoding.Config"
"""The tag that dynparam writes before each mapping in a file. It names a class of the package dynamic_reconfigure."""


def file_text(values: dict[str, Any]) -> str:
    """Return a configuration in the stock tool's file format, which both tools can load."""
    lines = dump_yaml(_wrap(values)).splitlines()
    for number, line in enumerate(lines[:-1]):
        next_line = lines[number + 1].strip()
        if line.endswith(":") and next_line in ("dictitems:", "state: []") and line.strip() != "dictitems:":
            lines[number] = f"{line} {_TAG}"
    return "\n".join([_TAG, *lines, ""])


def _wrap(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    wrapped = {"dictitems": {key: _wrap(item) for key, item in value.items()}} if value else {}
    return {**wrapped, "state": []}


def read_file_text(text: str, file_name: str) -> dict[str, Any]:
    """Parse a configuration file in the format of `file_text`, or in plain YAML. Several documents are merged.

    Args:
        text: the file's contents.
        file_name: the file's name, for error messages.

    Raises:
        ParameterError: the file is not a configuration.
    """
    values: dict[str, Any] = {}
    try:
        documents = load_all_yaml(re.sub(re.escape(_TAG) + r"[ \t]*$", "", text, flags=re.MULTILINE), file_name)
    except YamlError as error:
        raise ParameterError(str(error)) from None
    for document in documents:
        if not isinstance(document, dict):
            raise ParameterError(f"{file_name}: expected a dictionary of parameters, not {one_line(document, 60)!r}")
        values.update(_unwrap(document))
    return values


def _unwrap(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    if value.keys() <= {"dictitems", "state"} and value.get("state") == []:
        value = value.get("dictitems") or {}
    return {key: _unwrap(item) for key, item in value.items()}
