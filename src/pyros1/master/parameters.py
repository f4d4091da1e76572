"""The parameter tree (https://wiki.ros.org/Parameter%20Server). Pure.

Keys are global names; ``/`` is the whole tree. Only dicts are branches: what is inside a list has no key of its own
(M50). Values given to the tree belong to it; values taken from it must not be changed.

Trees are asked for far more often than they change, so each branch keeps its XML-RPC text once it was sent, until
something in it changes.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable
from typing import Any, Final

from pyros1.ground.names import SEP
from pyros1.master.registry import Members, Notice
from pyros1.wire.xmlrpc import PreparedDict

MAX_DEPTH: Final = 90
"""Deepest nesting of the tree, lists included: less than what one XML-RPC message may hold, so that a client can always
get the whole tree."""

_TOO_DEEP: Final = f"parameters cannot be nested deeper than {MAX_DEPTH} levels"
_MAX_INT: Final = 2**31


def _check(value: Any, depth: int) -> None:
    """Refuse values that could be stored but not sent.

    Raises:
        ValueError: says what is wrong.
    """
    if isinstance(value, int):
        if not -_MAX_INT <= value < _MAX_INT:
            raise ValueError(f"the integer {value} does not fit into 32 bits")
    elif value is None:
        raise ValueError("null values are not supported")
    elif isinstance(value, (dict, list, tuple)):
        if depth >= MAX_DEPTH:
            raise ValueError(_TOO_DEEP)
        for item in value.values() if isinstance(value, dict) else value:
            kind = item.__class__
            if kind is not str and kind is not float and kind is not bool:
                _check(item, depth + 1)


def _stored(value: Any, depth: int) -> Any:
    """Return the value in the tree's form: with branches in place of dicts, except for dicts inside lists.

    Raises:
        ValueError: it cannot be stored.
    """
    if not isinstance(value, dict):
        _check(value, depth)
        return value
    if depth >= MAX_DEPTH:
        raise ValueError(_TOO_DEEP)
    branch = PreparedDict(value)
    for name, item in value.items():
        kind = item.__class__
        if kind is not str and kind is not float and kind is not bool:
            branch[name] = _stored(item, depth + 1)
    return branch


def _path(key: str) -> list[str]:
    return [part for part in key.split(SEP) if part]


class Parameters:
    """The tree of all parameters."""

    def __init__(self) -> None:
        self._root = PreparedDict()
        self.version = 0
        """Grows with every change."""

    def set(self, key: str, value: Any) -> None:
        """Set a value; a dict replaces the whole branch (M46), a scalar on the way becomes a branch (M47).

        Raises:
            ValueError: the value cannot be stored: ``/`` must be a dict, there is no null, ints have 32 bits, depth is
                limited.
        """
        path = _path(key)
        stored = _stored(value, len(path))
        if not path:
            if not isinstance(stored, PreparedDict):
                raise ValueError("cannot set root of parameter tree to non-dictionary")
            self.version += 1
            self._root = stored
            return
        if len(path) > MAX_DEPTH:
            raise ValueError(_TOO_DEEP)
        self.version += 1
        branch = self._root
        for part in path[:-1]:
            branch.text = None
            below = branch.get(part)
            if not isinstance(below, PreparedDict):
                below = branch[part] = PreparedDict()
            branch = below
        branch.text = None
        branch[path[-1]] = stored

    def get(self, key: str) -> Any:
        """Return the value or branch at a key (M48).

        Raises:
            KeyError: nothing is set there.
        """
        value: Any = self._root
        for part in key.split(SEP):
            if part:
                if not isinstance(value, dict):
                    raise KeyError(key)
                value = value[part]
        return value

    def __contains__(self, key: str) -> bool:
        try:
            self.get(key)
        except KeyError:
            return False
        return True

    def delete(self, key: str) -> None:
        """Remove a value or branch.

        Raises:
            KeyError: nothing is set there; also for ``/``, which cannot be removed (M27).
        """
        path = _path(key)
        if not path or key not in self:
            raise KeyError(key)
        self.version += 1
        branch = self._root
        for part in path[:-1]:
            branch.text = None
            branch = branch[part]
        branch.text = None
        del branch[path[-1]]

    def search(self, namespace: str, key: str) -> str | None:
        """Find a key from a namespace upwards; only its first part has to exist (M52).

        Returns:
            The full key, None if it was not found.

        Raises:
            ValueError: the key is private, or the namespace not global.
        """
        if not key or key.startswith("~"):
            raise ValueError("invalid key")
        if not namespace.startswith(SEP):
            raise ValueError("namespace must be global")
        if key.startswith(SEP):
            return key if key in self else None
        first = _path(key)[0]
        above = _path(namespace)
        for count in range(len(above), -1, -1):
            where = SEP + "".join(part + SEP for part in above[:count])
            if where + first in self:
                return where + key
        return None

    def names(self) -> list[str]:
        """Return the keys of all values; empty branches have none (M31)."""
        found: list[str] = []
        _collect(self._root, SEP, found)
        return found


def _collect(branch: dict[str, Any], prefix: str, found: list[str]) -> None:
    for name, value in branch.items():
        if isinstance(value, dict):
            _collect(value, prefix + name + SEP, found)
        else:
            found.append(prefix + name)


def updates(subscribers: Members, key: str, value: Any, caller: str | None) -> list[Notice]:
    """Return the notices that a change of a parameter causes (M53, M54).

    Subscribers at or above the key get the key and its value; those below it get their own key and what is now there,
    ``{}`` if nothing. Keys are sent with a trailing slash. As in stock, subscribers below a key that was set to a
    scalar are not notified.

    Args:
        subscribers: key -> node -> API URI.
        key: what was set or deleted.
        value: the new value, ``{}`` for a deletion.
        caller: the node that set it, which is not notified of the value that it has set. None after a deletion.
    """
    if not subscribers:
        return []
    changed = _with_slash(key)
    notices: list[Notice] = []
    for subscribed in _affected_keys(subscribers, changed, value):
        nodes, mine = subscribers[subscribed], _with_slash(subscribed)
        if changed.startswith(mine):
            subject, news = changed, value
        else:
            subject, news = mine, _below(value, mine[len(changed) :].split(SEP))
        news = copy.deepcopy(news)  # a copy: it is sent later, when the tree may have changed again
        knows = caller if subject == changed else None
        notices += [Notice(api, node, "paramUpdate", subject, (news,)) for node, api in nodes.items() if node != knows]
    return notices


def _affected_keys(subscribers: Members, changed: str, value: Any) -> list[str]:
    """Return the keys at and above a change, and those below it if it has set a branch.

    Only for a branch is each key inspected: a thousand nodes may have subscribed to keys of their own.
    """
    parts = changed.split(SEP)
    above = [SEP.join(parts[:count]) or SEP for count in range(1, len(parts))]
    found = [key for key in above if key in subscribers]
    if isinstance(value, dict):
        found += [key for key in subscribers if key.startswith(changed) and key != SEP]
    return found


def _below(value: Any, path: Iterable[str]) -> Any:
    for part in path:
        if not part:
            continue
        if not isinstance(value, dict) or part not in value:
            return {}
        value = value[part]
    return value


def _with_slash(key: str) -> str:
    return key if key.endswith(SEP) else key + SEP
