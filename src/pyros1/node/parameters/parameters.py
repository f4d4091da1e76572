"""A node's access to the parameter server (https://wiki.ros.org/Parameter%20Server)."""

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

_MAX_FETCHES = 3
"""Maximum number of times to fetch a value that keeps changing."""


class Parameters:
    """Parameters by name, like a mapping: ``node.params["~rate"]``.

    Names are relative to the node's namespace, global (``/x``) or private (``~x``), and remappings apply to them.
    Thread-safe, and allowed in signal handlers.

    Args:
        master: client of the master, for everything that is not cached.
        resolve: resolves a name to a full name.
        get_api_uri: returns the URI of the node's slave API, to which the master sends changes.
        remappings: the unresolved remappings from the command line, for `search`.
        schedule: calls a function soon, in another thread; for the `Strand` that protects the copies.
        notify: calls a function from the program with an argument, in a thread other than the one that receives
            changes.
    """

    def __init__(
        self,
        master: MasterClient,
        resolve: Callable[[str], str],
        get_api_uri: Callable[[], str],
        remappings: Mapping[str, str],
        schedule: Callable[[Callable[[], None]], object] = lambda work: work(),
        notify: Callable[[Callable[[Any], object], Any], object] = lambda function, argument: function(argument),
    ) -> None:
        self._master = master
        self._resolve = resolve
        self._get_api_uri = get_api_uri
        self._remappings = remappings
        self._notify = notify
        self._cache = ParameterCache()
        self._strand = Strand(schedule)  # protects the copies
        self._listeners: list[Callable[[str, Any], object]] = []

    def __getitem__(self, name: str) -> Any:
        """Return a parameter's value: a number, a string, bytes, a list or a dict.

        Raises:
            ParameterNotSetError: the parameter is not set.
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
            SerializationError: the value is not a bool, a number, a str, bytes, or a list or dict of these.
        """
        key = self._resolve(name)
        versions_before = self._cache.versions()
        try:
            self._master.set_param(key, value)
        except SerializationError as error:
            raise SerializationError(
                f"parameter [{key}]: {error}. A parameter is a bool, number, str, bytes, list or dict of them"
            ) from None
        except BaseException:
            self._strand.do(self._cache.invalidate, key)  # only the response may be missing
            raise
        # the master notifies only other nodes (M54)
        self._strand.do(self._cache.set_locally, key, value, versions_before)

    def set(self, name: str, value: Any) -> None:
        """Set a parameter; the same as ``params[name] = value``."""
        self[name] = value

    def __delitem__(self, name: str) -> None:
        """Delete a parameter or a whole namespace.

        Raises:
            ParameterNotSetError: the parameter is not set.
        """
        key = self._resolve(name)
        try:
            self._master.delete_param(key)
        finally:  # if there is an error, only the response may be missing
            self._strand.do(self._cache.invalidate, key)

    def __contains__(self, name: str) -> bool:
        return self._master.has_param(self._resolve(name))

    def search(self, name: str) -> str | None:
        """Search for a parameter from the node's own namespace upwards; return its full name, or None if there is none.

        A remapping applies only if it is for exactly the given name (P22).
        """
        check_name(name, "search(name)")
        return self._master.search_param(self._remappings.get(name, name))

    def names(self) -> list[str]:
        """Return the full names of all parameters."""
        return self._master.get_param_names()

    def __iter__(self) -> Iterator[str]:
        return iter(self.names())

    def cached(self, name: str, default: Any = None) -> Any:
        """Return a parameter's value from a local copy that the master keeps up to date; fast enough for a loop.

        Args:
            name: the name of the parameter.
            default: the value to return while the parameter is not set.
        """
        key = self._resolve(name)
        value = self._cache.get(key)
        # In a signal handler, pending changes may have to wait until the interrupted function continues.
        if value is MISSING or self._strand.jobs:
            value = self._fetch(key)
        return default if value == {} else value

    def _fetch(self, key: str) -> Any:
        """Fetch a value from the master, subscribe to its changes, cache it and return it; {} if it is not set."""
        value: Any = None
        for _ in range(_MAX_FETCHES):
            fetch = self._cache.begin_fetch(key)
            try:
                value = self._master.subscribe_param(self._get_api_uri(), key)
            except MasterMethodError:  # the master cannot report changes, so the value is not cached
                self._strand.do(self._cache.abort_fetch, fetch)
                try:
                    return self._master.get_param(key)
                except ParameterNotSetError:
                    return {}
            except BaseException:
                self._strand.do(self._cache.abort_fetch, fetch)
                raise
            self._strand.do(self._cache.complete_fetch, fetch, value)
            cached = self._cache.get(key)
            if cached is not MISSING and not self._strand.jobs:
                return cached
        return value  # the value keeps changing; the next read fetches it again

    def refetch(self) -> None:
        """Fetch all local copies again, after the master was restarted and has lost the subscriptions."""
        for key in self._cache.names():
            self._fetch(key)

    def uncache(self, name: str) -> None:
        """Discard the local copy of a parameter that was created by `cached`."""
        key = self._resolve(name)
        if key in self._cache.names():
            self._strand.do(self._cache.drop, key)
            with contextlib.suppress(MasterMethodError):  # such a master sends no updates
                self._master.unsubscribe_param(self._get_api_uri(), key)

    def cached_names(self) -> list[str]:
        """Return the full names of the parameters with a local copy."""
        return self._cache.names()

    def update(self, key: str, value: Any) -> bool:
        """Apply a change reported by the master (S09); return whether there is a copy of that parameter."""
        is_cached = self._cache.is_affected_by(key)
        if is_cached:
            self._strand.do(self._cache.set_remotely, key, value)
            name = key.rstrip("/") or "/"  # masters append a slash
            for listener in self._listeners:
                self._strand.do(self._notify, partial(listener, name), value)
        return is_cached

    def on_update(self, callback: Callable[[str, Any], object]) -> None:
        """Call a function whenever a parameter that has a local copy changes.

        Args:
            callback: called with the parameter's full name and new value, which is an empty dict if the parameter was
                deleted. It runs where the node's callbacks run, for one change at a time.
        """
        self._listeners.append(callback)
