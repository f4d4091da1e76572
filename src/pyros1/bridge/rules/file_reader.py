"""Reads values from a bridge's YAML file. Errors contain file and line."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any, NoReturn, TypeVar

from pyros1.bridge.names import SiteNameError
from pyros1.bridge.transport.endpoints import EndpointError, check_endpoint
from pyros1.ground.errors import Error
from pyros1.ground.suggest import did_you_mean
from pyros1.values.reading import YamlError, load_yaml

Path = tuple[str | int, ...]
"""A value's position in a file: the keys and item numbers that lead to it."""
_T = TypeVar("_T")
_UNQUOTED = re.compile(r"[-\[,:]\s*[*!]\w*[:/]")
"""A name such as ``*:/odom`` or ``!/odom``, which YAML reads as an alias or a tag."""


class RulesError(Error, ValueError):
    """Rules are invalid. The message contains file and line."""


class FileReader:
    """Reads the values of a file. Each value has a path, by which its line is found for error messages.

    Args:
        text: the file's contents.
        where: its name, for errors.

    Attributes:
        places: the file and line of each endpoint and key name that has been read so far.

    Raises:
        RulesError: quotation marks are missing, or a key is repeated.
        YamlError: the text is not valid YAML for another reason.
    """

    def __init__(self, text: str, where: str) -> None:
        try:
            value = load_yaml(text, where)
        except YamlError as error:
            if _UNQUOTED.search(text):
                raise RulesError(f"{error}; quote names that begin with * or !, such as '*:/odom'") from error
            raise
        self._value = {} if value is None else value
        self._where = where
        self.places: dict[str, str] = {}
        self._lines, repeated = _line_numbers(text)
        if repeated is not None:
            path, line = repeated
            self._fail(path, f"{path[-1]!r:.40} was already set in line {line}: put both together")

    def _items(self, fields: Mapping[str, Any], key: str, path: Path = ()) -> list[tuple[Any, Path]]:
        """Return the items of a list with their paths; a single value counts as a list of one."""
        value = fields.get(key)
        if value is None:
            return []
        if isinstance(value, list):
            return [(item, (*path, key, number)) for number, item in enumerate(value)]
        return [(value, (*path, key))]

    def _mapping(self, value: Any, path: Path, keys: tuple[str, ...] | None) -> dict[str, Any]:
        if not isinstance(value, dict):
            self._fail(path, f"expected a mapping (name: value), not {value!r:.40}")
        for key in value:
            if keys is not None and key not in keys:
                hint = did_you_mean(str(key), keys)
                self._fail((*path, key), f"there is no setting {key!r:.40}{hint}; use {', '.join(keys)}")
        return value

    def _text(self, value: Any, path: Path) -> str:
        if not isinstance(value, str):
            self._fail(path, f"expected a string, not {value!r:.40}")
        return value

    def _endpoints(self, fields: Mapping[str, Any], key: str) -> tuple[str, ...]:
        """Return the endpoints in a list, or a single one."""
        found = []
        for item, path in self._items(fields, key):
            endpoint = self._checked(path, check_endpoint, self._text(item, path))
            self.places.setdefault(endpoint, self._place(path))
            found.append(endpoint)
        return tuple(found)

    def _checked(self, path: Path, function: Callable[[Any], _T], value: Any) -> _T:
        try:
            return function(value)
        except (SiteNameError, RulesError, EndpointError) as error:
            self._fail(path, str(error))

    def _fail(self, path: Path, problem: str) -> NoReturn:
        raise RulesError(f"{self._place(path)}: {problem}")

    def _place(self, path: Path) -> str:
        """Return the file and line of a value, or of its nearest existing parent."""
        while path not in self._lines and path:
            path = path[:-1]
        line = self._lines.get(path)
        return f"{self._where}:{line}" if line else self._where


def _line_numbers(text: str) -> tuple[dict[Path, int], tuple[Path, int] | None]:
    """Return the line of each value and key, by path, of a YAML text that `load_yaml` has accepted, and the first
    repeated key with the line of its first occurrence, which YAML would silently drop.
    """
    import yaml  # noqa: PLC0415 - slow to import

    found: dict[Path, int] = {}
    repeated: list[tuple[Path, int]] = []

    def walk(node: Any, path: Path) -> None:
        found.setdefault(path, node.start_mark.line + 1)
        if node.id == "mapping":
            keys: set[str] = set()
            for key, value in node.value:
                if key.id == "scalar":
                    key_path = (*path, key.value)
                    if key.value in keys:
                        repeated.append((key_path, found[key_path]))
                    keys.add(key.value)
                    found[key_path] = key.start_mark.line + 1
                    walk(value, key_path)
        elif node.id == "sequence":
            for number, item in enumerate(node.value):
                walk(item, (*path, number))

    root = yaml.compose(text, yaml.SafeLoader)
    if root is not None:
        walk(root, ())
    return found, repeated[0] if repeated else None
