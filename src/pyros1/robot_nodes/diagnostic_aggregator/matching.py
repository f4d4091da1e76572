"""Decides which diagnostics belong to an analyzer, and under which names it reports them (no I/O)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pyros1.robot_nodes.diagnostic_aggregator.patterns import NamePattern


@dataclass(frozen=True)
class Matcher:
    """Decides by its name whether a diagnostic status belongs to an analyzer.

    Attributes:
        names: complete names, including those of expected items.
        prefixes: prefixes of names.
        parts: substrings of names.
        patterns: regular expressions for complete names.
    """

    names: frozenset[str] = frozenset()
    prefixes: tuple[str, ...] = ()
    parts: tuple[str, ...] = ()
    patterns: tuple[NamePattern, ...] = ()

    def matches(self, name: str) -> bool:
        """Return whether the status with this name belongs to the analyzer."""
        return (
            name in self.names
            or name.startswith(self.prefixes)
            or any(part in name for part in self.parts)
            or any(pattern.matches(name) for pattern in self.patterns)
        )

    def __bool__(self) -> bool:
        """Return whether it could match anything."""
        return bool(self.names or self.prefixes or self.parts or self.patterns)


def join_path(base: str, name: str) -> str:
    """Return the path of an item with the given name below a base path; the path of the root is "/"."""
    path = name if base == "/" else f"{base}/{name}"
    return path if path.startswith("/") else f"/{path}"


def output_name(name: str, removed_prefixes: Sequence[str]) -> str:
    """Return the last part of the name under which an item is reported.

    Args:
        name: the name in /diagnostics, such as "driver: left/front". Its slashes become spaces, since slashes separate
            the parts of a path in the tree.
        removed_prefixes: prefixes to remove, together with the colon and the spaces after them.
    """
    result = name.replace("/", " ")
    for prefix in filter(None, removed_prefixes):
        # As in stock ROS, the colon and the spaces at the start are removed even if the prefix is not there.
        result = result.removeprefix(prefix.replace("/", " ")).removeprefix(":").lstrip(" ")
    return result
