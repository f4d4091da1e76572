"""Finds out, after a restart of the master, which nodes of the previous master are still running.

Each node is asked for its topics. A node that does not respond may only be suspended, or disconnected from the network,
so it is asked again. If the connection is refused, or another program responds, the node is gone: it is removed, and
other nodes are notified.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Final

from pyros1.ground.errors import Error, ProtocolError, XmlRpcFault
from pyros1.master.api import MasterApi
from pyros1.master.journal import JournalContents, boot_id
from pyros1.master.registry import RegisteredNode
from pyros1.net.blocking_connect import blocking_connect
from pyros1.net.hosts import parse_uri
from pyros1.net.loop import Loop
from pyros1.net.rpc_caller import RpcCaller

RECENT_S: Final = 60.0
"""The state is restored even without running nodes if the previous master died at most this many seconds ago."""
ANSWER_TIMEOUT_S: Final = 60.0
"""Seconds after which a node that has never responded is considered gone."""
_RETRY_S: Final = 5.0
_MASTER_NAME: Final = "/master"
_CONNECT_TIMEOUT_S: Final = 1.0
_MAX_PROBES: Final = 100
_Query = tuple[str, frozenset[str]]
"""A method, and topics: its result must contain at least one of them; without topics, any result is accepted."""


def stale_reason(journal: JournalContents, now: float, is_any_reachable: Callable[[Iterable[str]], bool]) -> str:
    """Return the reason why the state in a journal should not be restored; an empty string if it should be.

    Args:
        journal: the contents of the journal.
        now: the current time in seconds since the epoch.
        is_any_reachable: returns whether any of the given API URIs accepts connections; see `any_reachable`.
    """
    if journal.boot != boot_id():
        return "this machine has been restarted since then"
    if now - journal.last_alive_at <= RECENT_S:
        return ""
    # Only the nodes in the final state matter: the journal also contains every `rostopic echo` that has since exited.
    restored_api = MasterApi(notify=lambda _: None, log=lambda *_: None, on_shutdown=lambda _: None, pid=0)
    restored_api.restore(journal.calls)
    if is_any_reachable({node.api for node in restored_api.registry.nodes()}):
        return ""
    ended_at = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(journal.last_alive_at))
    return f"it ended at {ended_at}, and none of its nodes is running"


def any_reachable(api_uris: Iterable[str]) -> bool:
    """Return whether any of these API URIs accepts connections. This takes a few seconds at most."""
    uris = list(api_uris)[:_MAX_PROBES]
    if not uris:
        return False
    from concurrent.futures import ThreadPoolExecutor  # noqa: PLC0415 - rarely needed, and slow to import

    with ThreadPoolExecutor(min(len(uris), 32), "master: looks for nodes") as pool:
        return any(list(pool.map(_is_reachable, uris)))


def _is_reachable(api_uri: str) -> bool:
    try:
        blocking_connect(*parse_uri(api_uri), _CONNECT_TIMEOUT_S, lambda: None).close()
        return True
    except (OSError, Error):
        return False


class Recovery:
    """Asks nodes whether they are still running, on the loop.

    Args:
        loop, caller: the master's loop and RPC caller.
        nodes: the nodes in the journal.
        on_gone: called with each node that is gone, and the reason.
        on_done: called once, with the number of running nodes, when all nodes have responded or are gone.
    """

    def __init__(
        self,
        loop: Loop,
        caller: RpcCaller,
        nodes: Iterable[RegisteredNode],
        on_gone: Callable[[RegisteredNode, str], object],
        on_done: Callable[[int], object],
    ) -> None:
        self._loop = loop
        self._caller = caller
        self._on_gone = on_gone
        self._on_done = on_done
        self._deadline = time.monotonic() + ANSWER_TIMEOUT_S
        self._pending_nodes = list(nodes)
        self._num_alive = 0
        self._closed = False

    def start(self) -> None:
        """Start asking all nodes; if there are none, call ``on_done``."""
        if not self._pending_nodes:
            self._on_done(0)
        for node in list(self._pending_nodes):
            self._ask(node, _identity_queries(node))

    def close(self) -> None:
        """Stop asking."""
        self._closed = True

    def _ask(self, node: RegisteredNode, queries: Sequence[_Query]) -> None:
        if self._closed:
            return
        method = queries[0][0]
        try:
            self._caller.call(
                node.api, method, [_MASTER_NAME], lambda value, error: self._on_response(node, queries, value, error)
            )
        except Error as error:  # the API URI is not valid
            self._finish_node(node, str(error))

    def _on_response(self, node: RegisteredNode, queries: Sequence[_Query], value: Any, error: Error | None) -> None:
        if self._closed:
            return
        expected_topics = queries[0][1]
        if error is None:
            if not expected_topics or expected_topics & _parse_topics(value):
                self._finish_node(node, None)
            elif len(queries) > 1:
                self._ask(node, queries[1:])
            else:
                self._finish_node(node, "another program is using its port")
        elif isinstance(error, XmlRpcFault):
            self._finish_node(node, None)  # the program is a node that does not have the method
        elif isinstance(error, ProtocolError):
            self._finish_node(node, f"another program is using its port: {error}")
        elif isinstance(error.__cause__, ConnectionRefusedError):
            self._finish_node(node, str(error))
        elif time.monotonic() > self._deadline:
            self._finish_node(node, f"no answer within {ANSWER_TIMEOUT_S:.0f} s: {error}")
        else:
            self._loop.call_later(_RETRY_S, self._ask, node, queries)

    def _finish_node(self, node: RegisteredNode, gone_reason: str | None) -> None:
        self._pending_nodes.remove(node)
        if gone_reason is None:
            self._num_alive += 1
        else:
            self._on_gone(node, gone_reason)
        if not self._pending_nodes:
            self._on_done(self._num_alive)


def _identity_queries(node: RegisteredNode) -> list[_Query]:
    """Return queries that distinguish a node from another program that is now using its port."""
    queries = (("getPublications", node.publications), ("getSubscriptions", node.subscriptions))
    return [query for query in queries if query[1]] or [("getPid", frozenset())]


def _parse_topics(response: Any) -> frozenset[str]:
    """Return the topics in a response to ``getPublications`` or ``getSubscriptions``; none if it is malformed."""
    rows = response[2] if isinstance(response, list) and len(response) == 3 and isinstance(response[2], list) else []
    return frozenset(row[0] for row in rows if isinstance(row, list) and row and isinstance(row[0], str))
