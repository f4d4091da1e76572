"""The parameter tree of the master (https://wiki.ros.org/Parameter%20Server), without any communication.

Keys are global names; ``/`` is the entire tree. Only dicts are branches: items of a list have no keys (M50). The tree
owns the values passed to it; values returned by it must not be modified.

Trees are requested far more often than they change, so each branch that was sent caches its XML-RPC encoding until
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
"""Maximum nesting depth of the tree, including lists. It is lower than the maximum for an XML-RPC message, so that
clients can always get the entire tree."""

_TOO_DEEP: Final = f"parameters cannot be nested deeper than {MAX_DEPTH} levels"
_MAX_INT: Final = 2**31


def _check_sendable(value: Any, depth: int) -> None:
    """Check that a value can be sent to clients.

    Raises:
        ValueError: the value cannot be sent; the message says why.
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
            item_class = item.__class__
            if item_class is not str and item_class is not float and item_class is not bool:
                _check_sendable(item, depth + 1)


def _to_stored(value: Any, depth: int) -> Any:
    """Convert a value to the form in which it is stored: with branches in place of dicts, except inside lists.

    Raises:
        ValueError: the value cannot be stored.
    """
    if not isinstance(value, dict):
        _check_sendable(value, depth)
        return value
    if depth >= MAX_DEPTH:
        raise ValueError(_TOO_DEEP)
    branch = PreparedDict(value)
    for name, item in value.items():
        item_class = item.__class__
        if item_class is not str and item_class is not float and item_class is not bool:
            branch[name] = _to_stored(item, depth + 1)
    return branch


def _split_key(key: str) -> list[str]:
    return [part for part in key.split(SEP) if part]


class Parameters:
    """The tree of all parameters."""

    def __init__(self) -> None:
        self._root = PreparedDict()
        self.version = 0
        """Incremented with every change."""

    def set(self, key: str, value: Any) -> None:
        """Set a value. A dict replaces the whole branch (M46); a scalar along the path is replaced by a branch (M47).

        Raises:
            ValueError: the value cannot be stored: ``/`` must be a dict, null is not allowed, integers must fit into 32
                bits, and the depth is limited.
        """
        path = _split_key(key)
        stored = _to_stored(value, len(path))
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
            child = branch.get(part)
            if not isinstance(child, PreparedDict):
                child = branch[part] = PreparedDict()
            branch = child
        branch.text = None
        branch[path[-1]] = stored

    def get(self, key: str) -> Any:
        """Return the value or branch at a key (M48).

        Raises:
            KeyError: nothing is set at the key.
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
            KeyError: nothing is set at the key, or the key is ``/``, which cannot be removed (M27).
        """
        path = _split_key(key)
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
        """Search for a key from a namespace upwards; only the first part of the key has to exist (M52).

        Returns:
            The full key, or None if it was not found.

        Raises:
            ValueError: the key is empty or private, or the namespace is not global.
        """
        if not key or key.startswith("~"):
            raise ValueError("invalid key")
        if not namespace.startswith(SEP):
            raise ValueError("namespace must be global")
        if key.startswith(SEP):
            return key if key in self else None
        first_part = _split_key(key)[0]
        parts = _split_key(namespace)
        for count in range(len(parts), -1, -1):
            prefix = SEP + "".join(part + SEP for part in parts[:count])
            if prefix + first_part in self:
                return prefix + key
        return None

    def names(self) -> list[str]:
        """Return the keys of all values; empty branches are omitted (M31)."""
        names: list[str] = []
        _collect_names(self._root, SEP, names)
        return names


def _collect_names(branch: dict[str, Any], prefix: str, names: list[str]) -> None:
    for name, value in branch.items():
        if isinstance(value, dict):
            _collect_names(value, prefix + name + SEP, names)
        else:
            names.append(prefix + name)


def param_updates(subscribers: Members, key: str, value: Any, caller: str | None) -> list[Notice]:
    """Return the notices that result from a change of a parameter (M53, M54).

    Subscribers of the key or of a namespace above it receive the key and its value. Subscribers of a key below it
    receive their own key and its new value, or ``{}`` if it is no longer set. Keys are sent with a trailing slash. As
    in stock ROS, subscribers below a key that was set to a scalar are not notified.

    Args:
        subscribers: key -> node -> API URI.
        key: the key that was set or deleted.
        value: the new value; ``{}`` for a deletion.
        caller: the node that set the value; it is not notified. None for a deletion: all subscribers are notified.
    """
    if not subscribers:
        return []
    changed_key = _with_slash(key)
    notices: list[Notice] = []
    for subscribed in _affected_keys(subscribers, changed_key, value):
        nodes, subscribed_key = subscribers[subscribed], _with_slash(subscribed)
        if changed_key.startswith(subscribed_key):
            subject, update = changed_key, value
        else:
            subject, update = subscribed_key, _get_below(value, subscribed_key[len(changed_key) :].split(SEP))
        update = copy.deepcopy(update)  # the update is sent later, when the tree may have changed again
        skipped = caller if subject == changed_key else None
        notices += [
            Notice(api, node, "paramUpdate", subject, (update,)) for node, api in nodes.items() if node != skipped
        ]
    return notices


def _affected_keys(subscribers: Members, changed_key: str, value: Any) -> list[str]:
    """Return the subscribed keys at and above a change, and those below it if the new value is a branch.

    All subscribed keys are examined only if the new value is a branch, since there may be thousands of subscriptions.
    """
    parts = changed_key.split(SEP)
    prefixes = [SEP.join(parts[:count]) or SEP for count in range(1, len(parts))]
    keys = [key for key in prefixes if key in subscribers]
    if isinstance(value, dict):
        keys += [key for key in subscribers if key.startswith(changed_key) and key != SEP]
    return keys


def _get_below(value: Any, path: Iterable[str]) -> Any:
    for part in path:
        if not part:
            continue
        if not isinstance(value, dict) or part not in value:
            return {}
        value = value[part]
    return value


def _with_slash(key: str) -> str:
    return key if key.endswith(SEP) else key + SEP
