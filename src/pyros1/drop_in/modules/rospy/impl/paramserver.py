"""The node's copies of parameters."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pyros1.drop_in.module_attributes import module_hooks as _module_hooks
from pyros1.drop_in.process import PROCESS
from pyros1.master.parameters import Parameters

SEP = GLOBALNS = "/"


class ParamServerCache:
    """Copies of parameters that the master keeps up to date; created by `rospy.get_param_cached` and `set`."""

    def __init__(self) -> None:
        self._own_copies = Parameters()
        self._notifiers: list[Callable[[str, Any], object]] = []
        self._watching = False

    def get(self, key: str) -> Any:
        """Return the copy of a parameter.

        Raises:
            KeyError: there is no copy.
        """
        if key in self._own_copies:
            value = _copy_dicts(self._own_copies.get(key))
            if value == {}:  # this is how the master reports a deleted parameter
                raise KeyError(key)
            return value
        if not _is_cached(key):
            raise KeyError(key)
        missing_marker = object()
        value = _parameters().cached(key, missing_marker)
        if value is missing_marker:
            raise KeyError(key)
        return value

    def set(self, key: str, value: Any) -> None:
        """Store a copy of a parameter; the master does not keep this copy up to date."""
        self._own_copies.set(key, value)

    def delete(self, key: str) -> None:
        """Drop the copy of a parameter.

        Raises:
            KeyError: there is no copy; or ``key`` is the root of all parameters.
        """
        if key == SEP:
            raise KeyError("cannot delete root of parameter tree")
        if key in self._own_copies:
            self._own_copies.delete(key)
        elif _is_cached(key):
            _parameters().uncache(key)
        else:
            raise KeyError(key)

    def update(self, key: str, value: Any) -> None:
        """Apply a change of a parameter to its copy; an empty dict deletes it.

        Raises:
            KeyError: there is no copy.
        """
        node = PROCESS.node
        if key in self._own_copies:
            self._own_copies.set(key, value)
            self._notify(key, value)
        elif node is None or not node.params.update(node.resolve(key), value):
            raise KeyError(key)

    def set_notifier(self, notifier: Callable[[str, Any], object] | None) -> None:
        """Call a function with the name and value of each parameter that changes; None to stop."""
        self._notifiers = [] if notifier is None else [notifier]
        if not self._watching:
            self._watching = True
            PROCESS.add_start_callback(lambda node: node.params.on_update(self._notify))

    def _notify(self, key: str, value: Any) -> None:
        for notifier in self._notifiers:
            notifier(key, value)


def _copy_dicts(value: Any) -> Any:
    return {key: _copy_dicts(item) for key, item in value.items()} if isinstance(value, dict) else value


def _parameters() -> Any:
    return PROCESS.node.params if PROCESS.node is not None else None


def _is_cached(key: str) -> bool:
    """Return whether the node has a copy of a parameter."""
    node = PROCESS.node
    return node is not None and node.resolve(key) in node.params.cached_names()


_CACHE = ParamServerCache()


def get_param_server_cache() -> ParamServerCache:
    """Return the node's copies of parameters."""
    return _CACHE


__getattr__, __dir__ = _module_hooks(__name__)
