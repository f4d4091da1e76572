"""Converts parameters to and from the form that viewers use (no I/O)."""

from __future__ import annotations

import base64
import binascii
import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from pyros1.web.foxglove.requests import FrameError, SetParameter

MAX_VALUES = 100_000
"""Maximum number of parameters sent to viewers."""


class ParameterValues:
    """All parameters that viewers may see.

    Args:
        tree: the master's parameter tree.
        may_see: returns whether viewers may see a parameter.

    Attributes:
        flat: full name -> value.
    """

    def __init__(self, tree: Mapping[str, Any], may_see: Callable[[str], bool] = lambda name: True) -> None:
        self.flat: dict[str, Any] = {}
        self._tree: dict[str, Any] = {}
        pending: list[tuple[str, Any]] = [("", tree)]
        while pending and len(self.flat) < MAX_VALUES:
            name, value = pending.pop()
            if isinstance(value, Mapping) and (value or not name):
                pending += [(f"{name}/{key}", child) for key, child in value.items()]
            elif may_see(name):
                self._add(name, value)
        self.flat = dict(sorted(self.flat.items()))

    def _add(self, name: str, value: Any) -> None:
        self.flat[name] = value
        *folders, leaf = name[1:].split("/")
        branch = self._tree
        for folder in folders:
            if not isinstance(branch.get(folder), dict):  # a name in the path may also have a plain value
                branch[folder] = {}
            branch = branch[folder]
        branch[leaf] = value

    def get(self, name: str) -> Any:
        """Return a parameter's value, or a namespace's tree; None if neither exists under this name."""
        if name in self.flat:
            return self.flat[name]
        subtree: Any = self._tree
        for part in filter(None, name.split("/")):
            if not isinstance(subtree, dict) or part not in subtree:
                return None
            subtree = subtree[part]
        return subtree


def entry(name: str, value: Any) -> dict[str, Any]:
    """Return a parameter as an entry of the protocol's message parameterValues.

    Args:
        name: the parameter's full name.
        value: the parameter's value; None if it is not set.
    """
    if value is None:
        return {"name": name}
    if isinstance(value, (bytes, bytearray)):
        return {"name": name, "value": base64.b64encode(value).decode("ascii"), "type": "byte_array"}
    fields = {"name": name, "value": _to_json_types(value)}
    if _is_float(value):
        fields["type"] = "float64"  # otherwise 3.0 could not be distinguished from 3
    elif isinstance(value, (list, tuple)) and value and all(map(_is_float, value)):
        fields["type"] = "float64_array"
    return fields


def entries(values: ParameterValues, names: Iterable[str]) -> list[dict[str, Any]]:
    """Return the parameters with the given names, or all if none are given, in the form used in frames."""
    requested = list(dict.fromkeys(names))
    if not requested:
        return [entry(name, value) for name, value in values.flat.items()]
    return [entry(name, values.get(name)) for name in requested]


def value_to_set(parameter: SetParameter) -> Any:
    """Return the value that a viewer wants to give to a parameter, converted to the type that it specified.

    Raises:
        FrameError: the value does not have the type that the viewer specified.
    """
    value = parameter.value
    match parameter.type, value:
        case "byte_array", str():
            try:
                return base64.b64decode(value, validate=True)
            except (binascii.Error, ValueError):
                raise FrameError(f"the value of {parameter.name[:200]} is not base64") from None
        case "float64", int() | float() if not isinstance(value, bool):
            return _to_float(parameter.name, value)
        case "float64_array", list() if all(
            isinstance(each, (int, float)) and not isinstance(each, bool) for each in value
        ):
            return [_to_float(parameter.name, each) for each in value]
        case (("byte_array" | "float64" | "float64_array"), _):
            raise FrameError(f"the value of {parameter.name[:200]} is not a {parameter.type}")
        case "", _:
            return value
    raise FrameError(f"unknown parameter type {parameter.type[:100]!r}")


def _to_float(name: str, value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        raise FrameError(f"the value of {name[:200]} is too large") from None


def _is_float(value: Any) -> bool:
    return isinstance(value, float) and math.isfinite(value)


def _to_json_types(value: Any) -> Any:
    """Convert a value that may contain bytes, dates and non-finite floats to types that JSON supports."""
    if isinstance(value, dict):
        return {str(key): _to_json_types(child) for key, child in value.items()}
    if isinstance(value, (list, tuple)):
        return [_to_json_types(child) for child in value]
    if isinstance(value, (bytes, bytearray)):
        return base64.b64encode(value).decode("ascii")
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    return value if isinstance(value, (str, int)) or value is None else str(value)
