"""Looks up the addresses of nodes with the master, in one call for all nodes requested at the same time."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error, XmlRpcFault

if TYPE_CHECKING:
    from pyros1.net.loop import Loop
    from pyros1.net.rpc_caller import RpcCaller

LookupCallback = Callable[[str], object]
_TIMEOUT = 3.0


class Lookups:
    """Looks up addresses with the master, on the loop. Only one call is in progress at a time; requests that are made
    meanwhile are sent together afterwards.

    Args:
        loop: the node's loop.
        rpc: makes the calls.
        caller_id: full name of the calling node.
        master_uri: the master's URI.
    """

    def __init__(self, loop: Loop, rpc: RpcCaller, caller_id: str, master_uri: str) -> None:
        self._loop = loop
        self._rpc = rpc
        self._caller_id = caller_id
        self._uri = master_uri
        self._requests: dict[str, set[LookupCallback]] = {}
        self._is_call_pending = False
        self._lacks_multicall = False  # whether the master has no system.multicall

    def look_up(self, name: str, callback: LookupCallback) -> None:
        """Look up a node, and call ``callback(uri)`` with its address; if the master does not return an address, the
        callback is not called.
        """
        self._requests.setdefault(name, set()).add(callback)
        if not self._is_call_pending:
            self._is_call_pending = True
            self._loop.call_soon(self._send)  # after the other watches that poll now have made their requests

    def _send(self) -> None:
        self._is_call_pending = bool(self._requests)
        if not self._requests:
            return
        requests, self._requests = self._requests, {}
        names = list(requests)
        if self._lacks_multicall or len(names) == 1:
            for name in names[1:]:
                self._requests[name] = requests[name]
            on_reply = partial(self._on_reply, requests[names[0]])
            self._rpc.call(self._uri, "lookupNode", (self._caller_id, names[0]), on_reply, _TIMEOUT)
            return
        calls = [{"methodName": "lookupNode", "params": [self._caller_id, name]} for name in names]
        self._rpc.call(self._uri, "system.multicall", (calls,), partial(self._on_replies, requests), _TIMEOUT)

    def _on_reply(self, callbacks: set[LookupCallback], reply: Any, error: Error | None) -> None:
        self._deliver(callbacks, reply)
        self._send()

    def _on_replies(self, requests: dict[str, set[LookupCallback]], replies: Any, error: Error | None) -> None:
        if isinstance(error, XmlRpcFault):
            self._lacks_multicall = True
            self._requests = {**requests, **self._requests}
        elif isinstance(replies, list) and len(replies) == len(requests):
            for callbacks, reply in zip(requests.values(), replies, strict=True):
                if isinstance(reply, list) and len(reply) == 1:
                    self._deliver(callbacks, reply[0])
        self._send()

    @staticmethod
    def _deliver(callbacks: set[LookupCallback], reply: Any) -> None:
        """Pass the URI in a reply ``[code, message, uri]`` to the callbacks; anything else is ignored."""
        if isinstance(reply, list) and len(reply) == 3 and reply[0] == 1 and isinstance(reply[2], str) and reply[2]:
            for callback in callbacks:
                callback(reply[2])
