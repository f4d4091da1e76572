"""The master's API, called under the program's name."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

from pyros1.drop_in.binary import bytes_to_binary
from pyros1.drop_in.process import PROCESS
from pyros1.ground import names
from pyros1.ground.errors import MasterError, MasterMethodError, MasterUnreachableError, ParameterNotSetError
from pyros1.net.hosts import master_uri
from pyros1.net.master_client import MasterClient
from rospy.exceptions import ROSException
from rospy.names import get_caller_id, get_mappings, normalize_name_argument, resolve_name

if TYPE_CHECKING:
    from pyros1.node.parameters.parameters import Parameters

_T = TypeVar("_T")
_NAME_POSITIONS = {
    **dict.fromkeys(("deleteParam", "setParam", "getParam", "searchParam", "hasParam"), 0),
    **dict.fromkeys(("subscribeParam", "unsubscribeParam"), 1),
    **dict.fromkeys(("registerService", "lookupService", "unregisterService"), 0),
    **dict.fromkeys(("registerPublisher", "registerSubscriber", "unregisterPublisher", "unregisterSubscriber"), 0),
}
"""Method that resolves a name -> position of that name in its arguments."""


@contextmanager
def stock_connection_errors() -> Iterator[None]:
    """In a ``with`` block, raise ConnectionRefusedError, like stock, if the master does not respond."""
    try:
        yield
    except MasterUnreachableError as error:
        raise ConnectionRefusedError(str(error)) from None


class MasterProxy:
    """The master's methods: ``proxy.getSystemState()`` returns ``[code, message, value]``.

    Parameters are available as items: ``proxy["/name"]``.

    Args:
        uri: the master's URI; None for the one that the node, the command line or the environment specifies.

    Attributes:
        client: pyros1's client of the master.
        parameters: pyros1's parameters.
    """

    def __init__(self, uri: str | None) -> None:
        self._connect(uri)

    def _connect(self, uri: str | None) -> None:
        node = PROCESS.node
        if node is not None and node.ok() and uri in (None, node.master_uri):
            self.client: MasterClient = node.master
            self.parameters: Parameters = node.params
        else:
            from pyros1.node.parameters.parameters import Parameters

            special = names.parse_arguments([]).special if node is None else node.arguments.special
            self.client = MasterClient(get_caller_id(), uri or master_uri(os.environ, special))
            self.parameters = Parameters(
                self.client, resolve_name, lambda: PROCESS.node.uri if PROCESS.node else "", get_mappings()
            )

    @property
    def target(self) -> Any:
        """A ServerProxy for the master; its methods expect the caller's name as their first argument."""
        from xmlrpc.client import ServerProxy  # slow to import

        return ServerProxy(self.client.uri)

    def call_with_retry(self, action: Callable[[], _T]) -> _T:
        """Return the result of a function that calls the master.

        If the node shuts down in the meantime, the function is called again with a new connection.

        Raises:
            ConnectionRefusedError: the master does not respond.
        """
        client, node = self.client, PROCESS.node
        try:
            with stock_connection_errors():
                return action()
        except ConnectionRefusedError:
            if node is None or node.ok() or client is not node.master:
                raise
        self._connect(client.uri)  # this node has shut down and closed its connection: open a new one
        with stock_connection_errors():
            return action()

    def __getattr__(self, key: str) -> Callable[..., Any]:
        if key.startswith("__"):
            raise AttributeError(key)

        def call(*args: Any) -> Any:
            """Call the method.

            Raises:
                ConnectionRefusedError: the master does not respond.
                Fault: the master has no such method.
            """
            arguments = list(args)
            position = _NAME_POSITIONS.get(key)
            if position is not None and position < len(arguments) and key != "searchParam":
                arguments[position] = resolve_name(arguments[position])
            try:
                answer = self.call_with_retry(lambda: self.client.call_unchecked(key, *arguments))
            except MasterMethodError as error:
                from xmlrpc.client import Fault  # slow to import

                raise Fault(1, str(error)) from error
            return bytes_to_binary(answer) if key == "getParam" else answer

        return call

    def __getitem__(self, key: str) -> Any:
        """Return a parameter; raises KeyError if it is not set."""
        try:
            return bytes_to_binary(self.call_with_retry(lambda: self.parameters[normalize_name_argument(key)]))
        except ParameterNotSetError:
            raise KeyError(key) from None

    def __setitem__(self, key: str, val: Any) -> None:
        self.call_with_retry(lambda: self.parameters.__setitem__(normalize_name_argument(key), val))

    def __delitem__(self, key: str) -> None:
        """Delete a parameter; raises KeyError if it is not set."""
        try:
            self.call_with_retry(lambda: self.parameters.__delitem__(normalize_name_argument(key)))
        except ParameterNotSetError:
            raise KeyError(key) from None

    def __contains__(self, key: str) -> bool:
        return self.call_with_retry(lambda: normalize_name_argument(key) in self.parameters)

    def __iter__(self) -> Iterator[str]:
        return iter(self.call_with_retry(lambda: list(self.parameters.names())))

    def search_param(self, key: str) -> str | None:
        """Search for a parameter; return its full name, or None.

        Raises:
            ROSException: the name is private.
            TypeError: ``key`` is None.
        """
        if key is None:
            raise TypeError("cannot marshal None unless allow_none is enabled")
        try:
            return self.call_with_retry(lambda: self.parameters.search(str(key))) if key else None
        except MasterError as error:
            raise ROSException(f"cannot search for parameter: {error}") from None

    def get_param_cached(self, key: str) -> Any:
        """Return a parameter from a local copy that the master keeps up to date; raises KeyError if it is not set."""
        missing_marker = object()
        value = self.call_with_retry(lambda: self.parameters.cached(normalize_name_argument(key), missing_marker))
        if value is missing_marker:
            raise KeyError(key)
        return bytes_to_binary(value)
