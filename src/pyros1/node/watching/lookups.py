"""Asks the master where nodes are, with one call for all that are wanted at the same time."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error, XmlRpcFault

if TYPE_CHECKING:
    from pyros1.net.loop import Loop
    from pyros1.net.rpc_caller import RpcCaller

Told = Callable[[str], object]
_TIMEOUT = 3.0


class Lookups:
    """Questions to the master, on the loop. Only one call is under way; what comes meanwhile is asked after it.

    Args:
        loop: the node's loop.
        rpc: makes the calls.
        caller_id: full name of the asking node.
        master_uri: the master's URI.
    """

    def __init__(self, loop: Loop, rpc: RpcCaller, caller_id: str, master_uri: str) -> None:
        self._loop = loop
        self._rpc = rpc
        self._caller_id = caller_id
        self._uri = master_uri
        self._wanted: dict[str, set[Told]] = {}
        self._under_way = False
        self._one_by_one = False  # the master has no system.multicall

    def ask(self, name: str, told: Told) -> None:
        """Call ``told(uri)`` when the master has told where a node is; not if it does not know, or does not answer."""
        self._wanted.setdefault(name, set()).add(told)
        if not self._under_way:
            self._under_way = True
            self._loop.call_soon(self._send)  # after all watches whose turn it is

    def _send(self) -> None:
        self._under_way = bool(self._wanted)
        if not self._wanted:
            return
        asked, self._wanted = self._wanted, {}
        names = list(asked)
        if self._one_by_one or len(names) == 1:
            for name in names[1:]:
                self._wanted[name] = asked[name]
            done = partial(self._answered_one, asked[names[0]])
            self._rpc.call(self._uri, "lookupNode", (self._caller_id, names[0]), done, _TIMEOUT)
            return
        calls = [{"methodName": "lookupNode", "params": [self._caller_id, name]} for name in names]
        self._rpc.call(self._uri, "system.multicall", (calls,), partial(self._answered, asked), _TIMEOUT)

    def _answered_one(self, told: set[Told], reply: Any, error: Error | None) -> None:
        self._take(told, reply)
        self._send()

    def _answered(self, asked: dict[str, set[Told]], replies: Any, error: Error | None) -> None:
        if isinstance(error, XmlRpcFault):
            self._one_by_one = True
            self._wanted = {**asked, **self._wanted}
        elif isinstance(replies, list) and len(replies) == len(asked):
            for told, reply in zip(asked.values(), replies, strict=True):
                if isinstance(reply, list) and len(reply) == 1:
                    self._take(told, reply[0])
        self._send()

    @staticmethod
    def _take(told: set[Told], reply: Any) -> None:
        """Take ``[code, message, uri]``; anything else is no answer."""
        if isinstance(reply, list) and len(reply) == 3 and reply[0] == 1 and isinstance(reply[2], str) and reply[2]:
            for each in told:
                each(reply[2])
