"""Which diagnostics an analyzer takes, and what it calls them (no I/O)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pyros1.robot_nodes.diagnostic_aggregator.patterns import NamePattern


@dataclass(frozen=True)
class Matcher:
    """Decides by its name whether a diagnostic status belongs to an analyzer.

    Attributes:
        names: complete names, including those of expected items.
        prefixes: what names may begin with.
        parts: what names may contain.
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
        """Return whether there is anything that it could match."""
        return bool(self.names or self.prefixes or self.parts or self.patterns)


def join_path(base: str, name: str) -> str:
    """Return the path of what has a name below a path; the path of the root is "/"."""
    path = name if base == "/" else f"{base}/{name}"
    return path if path.startswith("/") else f"/{path}"


def output_name(name: str, removed_prefixes: Sequence[str]) -> str:
    """Return the last part of the name under which an item is reported.

    Args:
        name: the name in /diagnostics, such as "driver: left/front". A slash separates the parts of a name in the tree,
            so those in the name become spaces.
        removed_prefixes: which prefixes to remove, with the colon and the spaces after them.
    """
    result = name.replace("/", " ")
    for prefix in filter(None, removed_prefixes):
        # As in stock ROS, the colon and the spaces at the start are removed even if the prefix is not there.
        result = result.removeprefix(prefix.replace("/", " ")).removeprefix(":").lstrip(" ")
    return result
