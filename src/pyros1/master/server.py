"""A running master: the API served by an XML-RPC server, all on one loop thread."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final

from pyros1.master.api import LogFunction, MasterApi
from pyros1.master.journal import HEARTBEAT_S, Journal, JournalContents
from pyros1.master.notify import Notifier
from pyros1.master.recovery import Recovery
from pyros1.master.registry import RegisteredNode
from pyros1.net.loop import Loop
from pyros1.net.rpc_caller import RpcCaller
from pyros1.net.xmlrpc_server import ServerLimits, XmlRpcServer

if TYPE_CHECKING:
    from pyros1.net.allowlist import Allowlist

DEFAULT_PORT: Final = 11311
NOTIFY_TIMEOUT_S: Final = 10.0
_SHUTDOWN_DELAY_S: Final = 0.1
SPIN_TIME: Final = 150e-6
"""Seconds that the loop polls before it sleeps while calls follow each other quickly: waking up for each call would
take longer than serving it."""


def _no_log(level: str, text: str) -> None:
    pass


class Master:
    """A ROS master that runs in the current process.

    Args:
        port: port to listen on; 0 lets the system choose.
        bind_host: address to listen on: ``0.0.0.0`` for all machines, ``127.0.0.1`` for this machine only.
        advertised_host: the host in ``uri``.
        log: ``log(level, text)`` with level ``info``, ``warn`` or ``error``; called on the master's thread for each
            registration, parameter change and notification (M57).
        on_shutdown: called on the master's thread with the reason when a client calls ``shutdown`` (M13). The master
            does not stop by itself: call ``stop`` from another thread.
        notify_timeout: maximum number of seconds for a node to respond to a notification.
        log_calls: whether to log each call as well, with level ``debug``.
        limits: limits on the resources that clients may use.
        on_error: called with unexpected exceptions; None to write them to stderr.
        journal: records the state for recovery after a crash; removed by ``stop``. None for no recovery.
        previous: the journal of the previous master, whose state is restored. Nodes that are gone are removed,
            and other nodes are notified. None to start with an empty state.
        allowlist: decides which peers may connect; None admits all.
        warn: called on the master's thread with a message for the user when a node cannot be reached.
        on_restored: called on the master's thread when all nodes of the previous master have been checked, with the
            number of nodes still running and the names of nodes that are gone.
    """

    def __init__(
        self,
        *,
        port: int = DEFAULT_PORT,
        bind_host: str = "0.0.0.0",
        advertised_host: str = "localhost",
        log: LogFunction | None = None,
        on_shutdown: Callable[[str], object] | None = None,
        notify_timeout: float = NOTIFY_TIMEOUT_S,
        log_calls: bool = False,
        limits: ServerLimits = ServerLimits(),  # noqa: B008 - immutable
        on_error: Callable[[BaseException], object] | None = None,
        journal: Journal | None = None,
        previous: JournalContents | None = None,
        on_restored: Callable[[int, list[str]], object] | None = None,
        allowlist: Allowlist | None = None,
        warn: Callable[[str], object] = lambda text: None,
    ) -> None:
        self._port = port
        self._bind_host = bind_host
        self._advertised_host = advertised_host
        self._log = log or _no_log
        self._on_shutdown = on_shutdown
        self._limits = limits
        self._allowlist = allowlist
        self._loop = Loop("master", on_error, SPIN_TIME)
        self._caller = RpcCaller(self._loop, timeout=notify_timeout)
        self._notifier = Notifier(self._caller, self._log, warn, self._is_subscribed, self._loop.call_later)
        self._api = MasterApi(
            notify=self._notifier.send,
            log=self._log,
            on_shutdown=self._on_shutdown_request,
            pid=os.getpid(),
            log_calls=log_calls,
            record=None if journal is None else self._record,
        )
        self._journal = journal
        self._previous = previous
        self._on_restored = on_restored
        self._recovery: Recovery | None = None
        self._gone_nodes: list[str] = []
        self._server: XmlRpcServer | None = None
        self._stopped = threading.Event()

    def start(self) -> None:
        """Start listening and serving clients.

        Raises:
            OSError: the master cannot listen on the port; ``errno.EADDRINUSE`` if the port is in use.
        """
        self._server = XmlRpcServer(
            self._loop,
            self._api.dispatch,
            bind_host=self._bind_host,
            advertised_host=self._advertised_host,
            port=self._port,
            limits=self._limits,
            allowlist=self._allowlist,
            warn=self._on_problem,
        )
        self._caller.make_room = self._server.make_room
        self._api.uri = self._server.uri
        if self._previous is not None:
            self._api.restore(self._previous.calls)
            nodes = self._api.registry.nodes()
            self._recovery = Recovery(self._loop, self._caller, nodes, self._forget, self._on_recovered)
        if self._journal is not None:
            self._journal.rewrite(self._api.snapshot())
        self._loop.start()
        self._loop.call_soon(self._start_on_loop)
        self._log("info", f"Master initialized: port[{self._server.port}], uri[{self._server.uri}]")

    def stop(self, timeout: float = 5.0, *, keep_journal: bool = False) -> None:
        """Close the port and all connections and stop the thread; no effect if already stopped.

        Args:
            timeout: maximum number of seconds to wait.
            keep_journal: whether to keep the journal for the next master.
        """
        self._stopped.set()
        if self._server is not None:
            self._loop.run(self._close, timeout=timeout)
        self._loop.stop(timeout)
        if self._journal is not None:
            self._journal.close(remove=not keep_journal)
            self._journal = None

    @property
    def uri(self) -> str:
        """``http://host:port/``; empty before ``start``."""
        return self._api.uri

    @property
    def port(self) -> int:
        """The port that the master listens on; 0 before ``start``."""
        return self._server.port if self._server is not None else 0

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until a client calls ``shutdown`` or ``stop`` is called; return whether either has happened.

        Args:
            timeout: maximum number of seconds to wait; None for no limit.
        """
        return self._stopped.wait(timeout)

    def _on_problem(self, text: str) -> None:
        self._log("error", text)
        self._loop.warn(f"ERROR: the master {text}")

    def _is_subscribed(self, node: str, topic: str, api: str) -> bool:
        return self._api.registry.is_subscribed(node, topic, api)

    def _start_on_loop(self) -> None:
        if self._recovery is not None:
            self._recovery.start()
        if self._journal is not None:
            self._heartbeat()

    def _record(self, method: str, params: Sequence[Any]) -> None:
        if self._journal is None:
            return
        self._journal.add((method, params))
        if self._journal.has_grown:
            self._journal.rewrite(self._api.snapshot())

    def _heartbeat(self) -> None:
        if self._journal is None or self._stopped.is_set():
            return
        if self._journal.needs_rewrite:
            self._journal.rewrite(self._api.snapshot())
        self._journal.heartbeat()
        self._loop.call_later(HEARTBEAT_S, self._heartbeat)

    def _forget(self, node: RegisteredNode, gone_reason: str) -> None:
        """Remove a node of the previous master that is gone, unless it has registered again with another API URI."""
        if self._api.registry.node_api(node.name) != node.api:
            return
        self._gone_nodes.append(node.name)
        self._log("warn", f"[{node.name}], registered with the previous master, is gone: {gone_reason}")
        self._notifier.send(self._api.registry.forget(node.name, node.api))

    def _on_recovered(self, num_running: int) -> None:
        if self._journal is not None:
            self._journal.rewrite(self._api.snapshot())
        self._log(
            "info", f"{num_running} nodes of the previous master are still running, {len(self._gone_nodes)} are gone"
        )
        if self._on_restored is not None:
            self._on_restored(num_running, self._gone_nodes)

    def _close(self) -> None:
        if self._recovery is not None:
            self._recovery.close()
        if self._server is not None:
            self._server._close()
        self._caller._close()

    def _on_shutdown_request(self, reason: str) -> None:
        # Announced later, so that the client receives its response first.
        self._loop.call_later(_SHUTDOWN_DELAY_S, self._announce_shutdown, reason)

    def _announce_shutdown(self, reason: str) -> None:
        self._stopped.set()
        if self._on_shutdown is not None:
            self._on_shutdown(reason)
