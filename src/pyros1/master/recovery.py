"""After a restart: which nodes of the earlier master are still running.

Each is asked for its topics. No answer yet says nothing: a node may be suspended, a network away. A refused connection,
or an answer that another program gives, says that the node is gone. It is then removed, and other nodes are notified.
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
"""A master that died this many seconds ago is continued even if none of its nodes is left."""
ANSWER_TIMEOUT_S: Final = 60.0
"""Seconds after which a node that never answered is gone."""
_RETRY_S: Final = 5.0
_NAME: Final = "/master"
_CONNECT_TIMEOUT_S: Final = 1.0
_MAX_PROBES: Final = 100
_Query = tuple[str, frozenset[str]]
"""Method, and the topics of which the answer must have one; none: any answer will do."""


def stale_reason(found: JournalContents, now: float, answers: Callable[[Iterable[str]], bool]) -> str:
    """Say why a journal is not to be continued; empty if it is.

    Args:
        found: the journal.
        now: seconds since the epoch.
        answers: returns whether any of these API URIs is listened on; see `any_reachable`.
    """
    if found.boot != boot_id():
        return "this machine has been restarted since then"
    if now - found.last_alive <= RECENT_S:
        return ""
    # Not all that were ever registered: each `rostopic echo` of a long life is in the journal.
    state = MasterApi(notify=lambda _: None, log=lambda *_: None, on_shutdown=lambda _: None, pid=0)
    state.restore(found.calls)
    if answers({node.api for node in state.registry.nodes()}):
        return ""
    since = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(found.last_alive))
    return f"it ended at {since}, and none of its nodes is running"


def any_reachable(apis: Iterable[str]) -> bool:
    """Return whether a port of any of these URIs accepts connections. It takes seconds at most, usually much less."""
    uris = list(apis)[:_MAX_PROBES]
    if not uris:
        return False
    from concurrent.futures import ThreadPoolExecutor  # noqa: PLC0415 - rarely needed, and it takes time to load

    with ThreadPoolExecutor(min(len(uris), 32), "master: looks for nodes") as pool:
        return any(list(pool.map(_is_reachable, uris)))


def _is_reachable(api: str) -> bool:
    try:
        blocking_connect(*parse_uri(api), _CONNECT_TIMEOUT_S, lambda: None).close()
        return True
    except (OSError, Error):
        return False


class Recovery:
    """Asks nodes whether they are still running. On the loop.

    Args:
        loop, caller: of the master.
        nodes: those that the journal names.
        forget: called with a node that is gone, and the reason.
        done: called once when all have answered or are gone, with the number of running nodes.
    """

    def __init__(
        self,
        loop: Loop,
        caller: RpcCaller,
        nodes: Iterable[RegisteredNode],
        forget: Callable[[RegisteredNode, str], object],
        done: Callable[[int], object],
    ) -> None:
        self._loop = loop
        self._caller = caller
        self._forget = forget
        self._done = done
        self._deadline = time.monotonic() + ANSWER_TIMEOUT_S
        self._pending = list(nodes)
        self._num_alive = 0
        self._closed = False

    def begin(self) -> None:
        """Ask all."""
        if not self._pending:
            self._done(0)
        for node in list(self._pending):
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
                node.api, method, [_NAME], lambda value, error: self._answered(node, queries, value, error)
            )
        except Error as error:  # no URI
            self._end(node, str(error))

    def _answered(self, node: RegisteredNode, queries: Sequence[_Query], value: Any, error: Error | None) -> None:
        if self._closed:
            return
        expected = queries[0][1]
        if error is None:
            if not expected or expected & _topics(value):
                self._end(node, None)
            elif len(queries) > 1:
                self._ask(node, queries[1:])
            else:
                self._end(node, "another program is using its port")
        elif isinstance(error, XmlRpcFault):
            self._end(node, None)  # a node that lacks the method
        elif isinstance(error, ProtocolError):
            self._end(node, f"another program is using its port: {error}")
        elif isinstance(error.__cause__, ConnectionRefusedError):
            self._end(node, str(error))
        elif time.monotonic() > self._deadline:
            self._end(node, f"no answer within {ANSWER_TIMEOUT_S:.0f} s: {error}")
        else:
            self._loop.call_later(_RETRY_S, self._ask, node, queries)

    def _end(self, node: RegisteredNode, gone_reason: str | None) -> None:
        self._pending.remove(node)
        if gone_reason is None:
            self._num_alive += 1
        else:
            self._forget(node, gone_reason)
        if not self._pending:
            self._done(self._num_alive)


def _identity_queries(node: RegisteredNode) -> list[_Query]:
    """Return what distinguishes a node from another program that has its port now."""
    asked = (("getPublications", node.publications), ("getSubscriptions", node.subscriptions))
    return [each for each in asked if each[1]] or [("getPid", frozenset())]


def _topics(answer: Any) -> frozenset[str]:
    """Return the topics in the answer of ``getPublications`` or ``getSubscriptions``; none if it is malformed."""
    rows = answer[2] if isinstance(answer, list) and len(answer) == 3 and isinstance(answer[2], list) else []
    return frozenset(row[0] for row in rows if isinstance(row, list) and row and isinstance(row[0], str))
