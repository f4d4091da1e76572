"""Local copies of parameters, and which of them are up to date.

The master notifies a node of changes by other nodes, in order, but not of the node's own changes (M54). So if the node
and another node change a parameter at the same time, the node cannot know which change was the last. The copy is then
in *doubt*: the next read fetches it again. This can happen

* if another node's change, or a second one by the node, comes while a change by the node is under way;
* if another node changes what the node has changed: its change may be older, and late;
* if anything changes while a value is fetched, part of which the node has changed.

So every copy finally has the master's value, and a value that only one side changes costs no call.

Methods that change something are called in one strand (``strand.py``), the other methods in any thread.
"""

from __future__ import annotations

from typing import Any, Final

MISSING: Final = object()
"""Returned for a copy that does not exist, or is in doubt."""
_MAX_CHANGES = 1000
"""Maximum number of changes remembered while a value is fetched."""


class Fetch:
    """A value that is being fetched.

    Attributes:
        key: the parameter's full name.
        changes: the changes by other nodes meanwhile.
        is_stale: whether the node itself has changed it meanwhile, or there were too many changes.
    """

    def __init__(self, key: str) -> None:
        self.key = key
        self.changes: list[tuple[str, Any]] = []
        self.is_stale = False


class ParameterCache:
    """The local copies, by full name."""

    def __init__(self) -> None:
        self._values: dict[str, Any] = {}
        self._versions: dict[str, int] = {}  # number of changes of each value
        self._stale: dict[str, None] = {}
        self._set_here: dict[str, None] = {}  # names that the node has set and that have copies
        self._fetches: dict[Fetch, None] = {}

    def get(self, key: str) -> Any:
        """Return a copy, or MISSING."""
        return MISSING if key in self._stale else self._values.get(key, MISSING)

    def names(self) -> list[str]:
        """Return the names of all copies, in doubt or not."""
        return list(self._values)

    def versions(self) -> dict[str, int]:
        """Return the number of changes of each value, for `set_locally`."""
        return self._versions.copy()

    def knows(self, key: str) -> bool:
        """Return whether a change of that name affects a copy, or a value that is being fetched."""
        return any(_related(name, key) for name in self.names() + [fetch.key for fetch in list(self._fetches)])

    # In the strand, except `begin` ------------------------------------------------------------------------------------

    def begin(self, key: str) -> Fetch:
        """Note that a value will be fetched; `keep` or `abort_fetch` must follow."""
        fetch = Fetch(key)
        self._fetches[fetch] = None
        return fetch

    def abort_fetch(self, fetch: Fetch) -> None:
        """Note that it could not be fetched."""
        self._fetches.pop(fetch, None)

    def keep(self, fetch: Fetch, value: Any) -> None:
        """Keep a fetched value."""
        key = fetch.key
        self.abort_fetch(fetch)
        self._values[key] = value
        self._stale.pop(key, None)
        self._count(key)
        for change in fetch.changes:  # they overtook the answer
            self._change(key, *change)
        if fetch.is_stale or (fetch.changes and self._is_set_here(key)):
            self._stale[key] = None

    def set_remotely(self, key: str, value: Any) -> None:
        """Apply a change from the master."""
        for fetch in list(self._fetches):
            if _related(fetch.key, key):
                fetch.changes.append((key, value))
                if len(fetch.changes) > _MAX_CHANGES:
                    fetch.changes.clear()
                    fetch.is_stale = True
        set_here = self._is_set_here(key)
        for name in self._related_to(key):
            self._change(name, key, value)
            if set_here:
                self._stale[name] = None

    def set_locally(self, key: str, value: Any, before: dict[str, int]) -> None:
        """Apply a change made by the node itself.

        Args:
            before: the `versions` when the call to the master began.
        """
        for fetch in list(self._fetches):
            fetch.is_stale = fetch.is_stale or _related(fetch.key, key)
        for name in self._related_to(key):
            self._set_here[key] = None
            if self._versions.get(name) != before.get(name):
                self._stale[name] = None
            self._change(name, key, value)

    def invalidate(self, key: str) -> None:
        """Note that a parameter was changed, and that the master may or may not report the change."""
        for fetch in list(self._fetches):
            fetch.is_stale = fetch.is_stale or _related(fetch.key, key)
        for name in self._related_to(key):
            self._set_here[key] = None
            self._stale[name] = None
            self._count(name)

    def drop(self, key: str) -> None:
        """Remove a copy."""
        for copies in (self._values, self._versions, self._stale):
            copies.pop(key, None)
        for name in list(self._set_here):
            if not self._related_to(name):
                del self._set_here[name]

    def _related_to(self, key: str) -> list[str]:
        return [name for name in self._values if _related(name, key)]

    def _is_set_here(self, key: str) -> bool:
        return any(_related(name, key) for name in self._set_here)

    def _count(self, name: str) -> None:
        self._versions[name] = self._versions.get(name, 0) + 1

    def _change(self, name: str, key: str, value: Any) -> None:
        """Change one copy; a change below or above its name affects it as well (M53)."""
        name_path, key_path = _path(name), _path(key)
        if len(key_path) >= len(name_path):
            self._values[name] = _with_value(self._values[name], key_path[len(name_path) :], value)
        else:
            for part in name_path[len(key_path) :]:
                value = value.get(part, {}) if isinstance(value, dict) else {}
            self._values[name] = value
        self._count(name)


def _path(key: str) -> list[str]:
    return [part for part in key.split("/") if part]


def _related(name: str, key: str) -> bool:
    """Return whether one name is the same as the other, or above it."""
    return all(a == b for a, b in zip(_path(name), _path(key), strict=False))


def _with_value(tree: Any, path: list[str], value: Any) -> Any:
    """Return a copy of ``tree`` with the value at ``path`` replaced; an empty dict removes it."""
    if not path:
        return value
    copy = dict(tree) if isinstance(tree, dict) else {}
    below = _with_value(copy.get(path[0]), path[1:], value)
    if below == {}:
        copy.pop(path[0], None)
    else:
        copy[path[0]] = below
    return copy
