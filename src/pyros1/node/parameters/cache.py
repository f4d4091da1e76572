"""Local copies of parameters, and whether they are up to date.

The master notifies a node of changes by other nodes, in order, but not of the node's own changes (M54). If this node
and another node change a parameter at the same time, this node cannot know which change was made last. The copy is then
*stale*, and the next read fetches it again. This can happen

* if there is a change by another node, or a second one by this node, while a change by this node is in progress;
* if another node changes a parameter that this node has changed, as the notification may be delayed;
* if a parameter changes while it is fetched, and this node has changed part of it.

So every copy eventually has the master's value, and no calls are needed for a value that only one side changes.

Methods that change the copies are called in one strand (``strand.py``); the others are thread-safe.
"""

from __future__ import annotations

from typing import Any, Final

MISSING: Final = object()
"""Value that `ParameterCache.get` returns for a copy that does not exist or is stale."""
_MAX_CHANGES = 1000
"""Maximum number of changes remembered while a value is fetched."""


class Fetch:
    """A request for a parameter's value that is in progress.

    Attributes:
        key: the parameter's full name.
        changes: changes by other nodes since the request was sent.
        is_stale: whether this node has changed the parameter since then, or there were too many changes.
    """

    def __init__(self, key: str) -> None:
        self.key = key
        self.changes: list[tuple[str, Any]] = []
        self.is_stale = False


class ParameterCache:
    """The local copies of parameters, by full name."""

    def __init__(self) -> None:
        self._values: dict[str, Any] = {}
        self._versions: dict[str, int] = {}  # number of changes of each value
        self._stale: dict[str, None] = {}
        self._locally_set: dict[str, None] = {}  # names that this node has set and that have copies
        self._fetches: dict[Fetch, None] = {}

    def get(self, key: str) -> Any:
        """Return the copy of a parameter; MISSING if there is none or it is stale."""
        return MISSING if key in self._stale else self._values.get(key, MISSING)

    def names(self) -> list[str]:
        """Return the names of all copies, including stale ones."""
        return list(self._values)

    def versions(self) -> dict[str, int]:
        """Return how often each value has changed so far; see the argument ``versions_before`` of `set_locally`."""
        return self._versions.copy()

    def is_affected_by(self, key: str) -> bool:
        """Return whether a change of ``key`` affects a copy or a value that is being fetched."""
        return any(_are_related(name, key) for name in self.names() + [fetch.key for fetch in list(self._fetches)])

    # In the strand, except `begin_fetch` ------------------------------------------------------------------------------

    def begin_fetch(self, key: str) -> Fetch:
        """Record that a value is being fetched; return the fetch, for `complete_fetch` or `abort_fetch`."""
        fetch = Fetch(key)
        self._fetches[fetch] = None
        return fetch

    def abort_fetch(self, fetch: Fetch) -> None:
        """Record that a value could not be fetched."""
        self._fetches.pop(fetch, None)

    def complete_fetch(self, fetch: Fetch, value: Any) -> None:
        """Keep a fetched value, with the changes that other nodes have made meanwhile."""
        key = fetch.key
        self.abort_fetch(fetch)
        self._values[key] = value
        self._stale.pop(key, None)
        self._increment_version(key)
        for change in fetch.changes:  # these arrived before the response
            self._change_copy(key, *change)
        if fetch.is_stale or (fetch.changes and self._is_set_locally(key)):
            self._stale[key] = None

    def set_remotely(self, key: str, value: Any) -> None:
        """Apply a change by another node, which the master has reported."""
        for fetch in list(self._fetches):
            if _are_related(fetch.key, key):
                fetch.changes.append((key, value))
                if len(fetch.changes) > _MAX_CHANGES:
                    fetch.changes.clear()
                    fetch.is_stale = True
        is_set_locally = self._is_set_locally(key)
        for name in self._related_to(key):
            self._change_copy(name, key, value)
            if is_set_locally:
                self._stale[name] = None

    def set_locally(self, key: str, value: Any, versions_before: dict[str, int]) -> None:
        """Apply a change made by the node itself.

        Args:
            key: the parameter's full name.
            value: the new value.
            versions_before: the `versions` at the start of the call to the master.
        """
        for fetch in list(self._fetches):
            fetch.is_stale = fetch.is_stale or _are_related(fetch.key, key)
        for name in self._related_to(key):
            self._locally_set[key] = None
            if self._versions.get(name) != versions_before.get(name):
                self._stale[name] = None
            self._change_copy(name, key, value)

    def invalidate(self, key: str) -> None:
        """Mark the copies of a changed parameter as stale: it is unknown whether the master will report the change."""
        for fetch in list(self._fetches):
            fetch.is_stale = fetch.is_stale or _are_related(fetch.key, key)
        for name in self._related_to(key):
            self._locally_set[key] = None
            self._stale[name] = None
            self._increment_version(name)

    def drop(self, key: str) -> None:
        """Remove the copy of a parameter."""
        for copies in (self._values, self._versions, self._stale):
            copies.pop(key, None)
        for name in list(self._locally_set):
            if not self._related_to(name):
                del self._locally_set[name]

    def _related_to(self, key: str) -> list[str]:
        return [name for name in self._values if _are_related(name, key)]

    def _is_set_locally(self, key: str) -> bool:
        return any(_are_related(name, key) for name in self._locally_set)

    def _increment_version(self, name: str) -> None:
        self._versions[name] = self._versions.get(name, 0) + 1

    def _change_copy(self, name: str, key: str, value: Any) -> None:
        """Apply a change of ``key`` to the copy of ``name``; the two names are related, see `_are_related` (M53)."""
        name_path, key_path = _split_name(name), _split_name(key)
        if len(key_path) >= len(name_path):
            self._values[name] = _with_value(self._values[name], key_path[len(name_path) :], value)
        else:
            for part in name_path[len(key_path) :]:
                value = value.get(part, {}) if isinstance(value, dict) else {}
            self._values[name] = value
        self._increment_version(name)


def _split_name(key: str) -> list[str]:
    return [part for part in key.split("/") if part]


def _are_related(name: str, key: str) -> bool:
    """Return whether two names are equal, or one is a namespace that contains the other."""
    return all(a == b for a, b in zip(_split_name(name), _split_name(key), strict=False))


def _with_value(tree: Any, path: list[str], value: Any) -> Any:
    """Return a copy of ``tree`` with the value at ``path`` replaced; an empty dict removes the value."""
    if not path:
        return value
    copy = dict(tree) if isinstance(tree, dict) else {}
    child = _with_value(copy.get(path[0]), path[1:], value)
    if child == {}:
        copy.pop(path[0], None)
    else:
        copy[path[0]] = child
    return copy
