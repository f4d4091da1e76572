"""A node's view of the parameter server (https://wiki.ros.org/Parameter%20Server)."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.errors import MasterMethodError, ParameterNotSetError

if TYPE_CHECKING:
    from pyros1.net.master_client import MasterClient

_MISSING = object()


class Parameters:
    """Parameters by name, like a mapping: ``node.params["~rate"]``.

    Names are relative to the node's namespace, global (``/x``) or private (``~x``), and follow the remappings.

    Args:
        master: asked for everything that is not cached.
        resolve: makes a full name.
        api: the node's slave API, which the master tells about changes.
        remappings: of the command line, as written; `search` follows them.
    """

    def __init__(
        self,
        master: MasterClient,
        resolve: Callable[[str], str],
        api: Callable[[], str],
        remappings: Mapping[str, str],
    ) -> None:
        self._master = master
        self._resolve = resolve
        self._api = api
        self._remappings = remappings
        self._cache: dict[str, Any] = {}
        self._lock = threading.Lock()  # one subscription at a time
        self._overtaking: list[tuple[str, Any]] | None = None  # updates that come while a subscription is under way

    def __getitem__(self, name: str) -> Any:
        """Return a parameter's value: a number, a string, bytes, a list or a dict.

        Raises:
            ParameterNotSetError: it is not set.
        """
        return self._master.get_param(self._resolve(name))

    def get(self, name: str, default: Any = None) -> Any:
        """Return a parameter's value, or ``default`` if it is not set."""
        try:
            return self[name]
        except ParameterNotSetError:
            return default

    def __setitem__(self, name: str, value: Any) -> None:
        """Set a parameter; a dict replaces the whole namespace of that name."""
        key = self._resolve(name)
        self._master.set_param(key, value)
        self.update(key, value)  # the master tells everybody but us (M54)

    def set(self, name: str, value: Any) -> None:
        """Set a parameter; a dict replaces the whole namespace of that name."""
        self[name] = value

    def __delitem__(self, name: str) -> None:
        """Delete a parameter or a namespace of them.

        Raises:
            ParameterNotSetError: it is not set.
        """
        self._master.delete_param(self._resolve(name))

    def __contains__(self, name: str) -> bool:
        return self._master.has_param(self._resolve(name))

    def search(self, name: str) -> str | None:
        """Look for ``name`` in the node's own namespace, then upwards; return the full name found, or None.

        A remapping of exactly this name is followed (P22).
        """
        return self._master.search_param(self._remappings.get(name, name))

    def names(self) -> list[str]:
        """Return the full names of all parameters."""
        return self._master.get_param_names()

    def __iter__(self) -> Iterator[str]:
        return iter(self.names())

    def cached(self, name: str, default: Any = None) -> Any:
        """Return a parameter's value from a local copy that the master keeps up to date; fast in a loop.

        Args:
            default: returned while the parameter is not set.
        """
        key = self._resolve(name)
        value = self._cache.get(key, _MISSING)
        if value is _MISSING:
            with self._lock:
                value = self._cache.get(key, _MISSING)
                if value is _MISSING:
                    value = self._subscribe(key)
        return default if value == {} else value

    def _subscribe(self, key: str) -> Any:
        """Ask the master for a value and its updates, and keep it. An update may overtake the answer. Lock held."""
        self._overtaking = []
        try:
            self._cache[key] = self._master.subscribe_param(self._api(), key)
        except MasterMethodError:  # nobody would tell us of changes: asked each time, and not kept
            try:
                return self._master.get_param(key)
            except ParameterNotSetError:
                return {}
        finally:
            overtaking, self._overtaking = self._overtaking, None
            for update in overtaking:
                self.update(*update)
        return self._cache[key]

    def renew(self) -> None:
        """Fetch all local copies again, from a master that was restarted and does not know of them."""
        with self._lock:
            for key in list(self._cache):
                self._subscribe(key)

    def uncache(self, name: str) -> None:
        """Drop the local copy of a parameter that `cached` made."""
        key = self._resolve(name)
        with self._lock:
            if self._cache.pop(key, _MISSING) is not _MISSING:
                with contextlib.suppress(MasterMethodError):  # then its updates are for nobody
                    self._master.unsubscribe_param(self._api(), key)

    def cached_names(self) -> list[str]:
        """Return the full names of the parameters with a local copy."""
        return list(self._cache)

    def update(self, key: str, value: Any) -> bool:
        """Take a change from the master (S09); return whether a copy is kept of that parameter.

        A change below or above a cached name concerns it too (M53).
        """
        overtaking = self._overtaking
        known = overtaking is not None
        if overtaking is not None:
            overtaking.append((key, value))
        key = key.rstrip("/") or "/"
        for name in list(self._cache):
            if name == key:
                self._cache[name] = value
                known = True
            elif key.startswith(name.rstrip("/") + "/"):
                self._cache[name] = _merged(self._cache[name], key[len(name.rstrip("/")) + 1 :].split("/"), value)
                known = True
            elif name.startswith(key.rstrip("/") + "/"):
                below = value
                for part in name[len(key.rstrip("/")) + 1 :].split("/"):
                    below = below.get(part, {}) if isinstance(below, dict) else {}
                self._cache[name] = below
                known = True
        return known


def _merged(tree: Any, path: list[str], value: Any) -> Any:
    """Return a copy of ``tree`` with the value at ``path`` replaced; an empty dict removes it."""
    if not path:
        return value
    copy = dict(tree) if isinstance(tree, dict) else {}
    below = _merged(copy.get(path[0]), path[1:], value)
    if below == {}:
        copy.pop(path[0], None)
    else:
        copy[path[0]] = below
    return copy
