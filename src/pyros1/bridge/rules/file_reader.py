"""Reads values from a bridge's YAML file. Errors say file and line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NoReturn, TypeVar

from pyros1.bridge.names import SiteNameError
from pyros1.ground.errors import Error
from pyros1.ground.suggest import did_you_mean
from pyros1.values.reading import load_yaml

Path = tuple[str | int, ...]
"""Where a value is in a file: the keys and numbers of items that lead to it."""
_T = TypeVar("_T")


class RulesError(Error, ValueError):
    """Rules are not valid. The message says where."""


class FileReader:
    """Reads the values of a file. Each value has a path, by which errors find its line.

    Args:
        text: the file's contents.
        where: its name, for errors.

    Raises:
        YamlError: the text is not valid YAML.
    """

    def __init__(self, text: str, where: str) -> None:
        value = load_yaml(text, where)
        self._value = {} if value is None else value
        self._where = where
        self._lines = _line_numbers(text)

    def _items(self, fields: Mapping[str, Any], key: str, path: Path = ()) -> list[tuple[Any, Path]]:
        """Return the items of a list with their paths; a single value stands for a list of one."""
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

    def _checked(self, path: Path, function: Callable[[Any], _T], value: Any) -> _T:
        try:
            return function(value)
        except (SiteNameError, RulesError) as error:
            self._fail(path, str(error))

    def _fail(self, path: Path, problem: str) -> NoReturn:
        while path not in self._lines and path:
            path = path[:-1]
        line = self._lines.get(path)
        raise RulesError(f"{self._where}:{line}: {problem}" if line else f"{self._where}: {problem}")


def _line_numbers(text: str) -> dict[Path, int]:
    """Return the line of each value and key of a YAML text that `load_yaml` has accepted, by path."""
    import yaml  # noqa: PLC0415 - slow to import

    found: dict[Path, int] = {}

    def walk(node: Any, path: Path) -> None:
        found.setdefault(path, node.start_mark.line + 1)
        if node.id == "mapping":
            for key, value in node.value:
                if key.id == "scalar":
                    key_path = (*path, key.value)
                    found[key_path] = key.start_mark.line + 1
                    walk(value, key_path)
        elif node.id == "sequence":
            for number, item in enumerate(node.value):
                walk(item, (*path, number))

    root = yaml.compose(text, yaml.SafeLoader)
    if root is not None:
        walk(root, ())
    return found
