"""A node's view of the parameter server (https://wiki.ros.org/Parameter%20Server)."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import MasterMethodError, ParameterNotSetError, SerializationError
from pyros1.node.checks import check_name
from pyros1.node.parameters.cache import MISSING, ParameterCache
from pyros1.node.strand import Strand

if TYPE_CHECKING:
    from pyros1.net.master_client import MasterClient

_TRIES = 3
"""Maximum number of times a value is fetched if it keeps changing meanwhile."""


class Parameters:
    """Parameters by name, like a mapping: ``node.params["~rate"]``.

    Names are relative to the node's namespace, global (``/x``) or private (``~x``), and follow the remappings.
    Any thread or signal handler may use them.

    Args:
        master: client of the master, for all that is not cached.
        resolve: returns the full name that a name stands for.
        api: URI of the node's slave API, to which the master sends changes.
        remappings: of the command line, as written; `search` follows them.
        later: calls a function soon, on another thread.
        notify: calls a function of the program with a change, in another thread than the one that receives changes.
    """

    def __init__(
        self,
        master: MasterClient,
        resolve: Callable[[str], str],
        api: Callable[[], str],
        remappings: Mapping[str, str],
        later: Callable[[Callable[[], None]], object] = lambda work: work(),
        notify: Callable[[Callable[[Any], object], Any], object] = lambda function, news: function(news),
    ) -> None:
        self._master = master
        self._resolve = resolve
        self._api = api
        self._remappings = remappings
        self._notify = notify
        self._cache = ParameterCache()
        self._strand = Strand(later)  # of the copies
        self._watchers: list[Callable[[str, Any], object]] = []

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
        """Set a parameter; a dict replaces the whole namespace of that name.

        Raises:
            SerializationError: it is not a bool, a number, a str, bytes, or a list or dict of these.
        """
        key = self._resolve(name)
        before = self._cache.versions()
        try:
            self._master.set_param(key, value)
        except SerializationError as error:
            raise SerializationError(
                f"parameter [{key}]: {error}. A parameter is a bool, number, str, bytes, list or dict of them"
            ) from None
        self._strand.do(self._cache.set_locally, key, value, before)  # the master notifies only other nodes (M54)

    def set(self, name: str, value: Any) -> None:
        """Set a parameter; a dict replaces the whole namespace of that name."""
        self[name] = value

    def __delitem__(self, name: str) -> None:
        """Delete a parameter or a namespace of them.

        Raises:
            ParameterNotSetError: it is not set.
        """
        key = self._resolve(name)
        self._master.delete_param(key)
        self._strand.do(self._cache.invalidate, key)

    def __contains__(self, name: str) -> bool:
        return self._master.has_param(self._resolve(name))

    def search(self, name: str) -> str | None:
        """Search ``name`` in the node's own namespace, then upwards; return the full name found, or None.

        A remapping of exactly this name is followed (P22).
        """
        check_name(name, "search(name)")
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
        value = self._cache.get(key)
        if (
            value is MISSING or self._strand.jobs
        ):  # in a signal handler, changes may wait until the interrupted function continues
            value = self._fetch(key)
        return default if value == {} else value

    def _fetch(self, key: str) -> Any:
        """Request a value and its updates from the master, and cache the value."""
        value: Any = None
        for _ in range(_TRIES):
            fetch = self._cache.begin(key)
            try:
                value = self._master.subscribe_param(self._api(), key)
            except MasterMethodError:  # the master would report no changes: fetched each time, and not cached
                self._strand.do(self._cache.abort_fetch, fetch)
                try:
                    return self._master.get_param(key)
                except ParameterNotSetError:
                    return {}
            except BaseException:
                self._strand.do(self._cache.abort_fetch, fetch)
                raise
            self._strand.do(self._cache.keep, fetch, value)
            kept = self._cache.get(key)
            if kept is not MISSING and not self._strand.jobs:
                return kept
        return value  # it changes all the time; the next read fetches it again

    def refetch(self) -> None:
        """Fetch all local copies again, from a master that was restarted and has lost the subscriptions."""
        for key in self._cache.names():
            self._fetch(key)

    def uncache(self, name: str) -> None:
        """Drop the local copy of a parameter that `cached` made."""
        key = self._resolve(name)
        if key in self._cache.names():
            self._strand.do(self._cache.drop, key)
            with contextlib.suppress(MasterMethodError):  # then it sends no updates
                self._master.unsubscribe_param(self._api(), key)

    def cached_names(self) -> list[str]:
        """Return the full names of the parameters with a local copy."""
        return self._cache.names()

    def update(self, key: str, value: Any) -> bool:
        """Apply a change from the master (S09); return whether that parameter has a copy."""
        known = self._cache.knows(key)
        if known:
            self._strand.do(self._cache.set_remotely, key, value)
            name = key.rstrip("/") or "/"  # masters send it with a trailing slash
            for watcher in self._watchers:
                self._strand.do(self._notify, partial(watcher, name), value)
        return known

    def on_update(self, callback: Callable[[str, Any], object]) -> None:
        """Call a function with the full name and new value at each change that the master sends for the local copies.

        The value of a parameter that was deleted is an empty dict.

        Args:
            callback: called where the node's callbacks run, one change after the other.
        """
        self._watchers.append(callback)
