"""The context shared by the parts of a node: its name, loop thread and log, and whether it is shutting down."""

from __future__ import annotations

import os
import socket
import threading
from collections.abc import Callable, Mapping
from functools import cached_property
from time import monotonic
from typing import TYPE_CHECKING, Any, Protocol

from pyros1.ground.errors import NodeError, NodeShutdownError, UnknownHostError
from pyros1.net.connectivity import connectivity_hint
from pyros1.net.loop import Loop, LoopThread
from pyros1.net.signal_safe import Event
from pyros1.node.checks import check_timeout
from pyros1.node.log.levels import ERROR
from pyros1.node.subscribing.threads import DeliveryThreads

if TYPE_CHECKING:
    from pyros1.net.allowlist import Allowlist
    from pyros1.net.hosts import LocalAddress
    from pyros1.net.rpc_caller import RpcCaller
    from pyros1.node.callback_queue import CallbackQueue
    from pyros1.node.log.logger import Log
    from pyros1.node.subscribing.delivery_loop import DeliveryLoop
    from pyros1.node.subscribing.queues import Source
    from pyros1.wire.handshake import TopicType

MAX_UNKNOWN_HOSTS = 1000


class PublicationInterface(Protocol):
    """The parts of a publication that the rest of the node uses; see `publishing.publication.Publication`."""

    topic: str

    @property
    def type(self) -> TopicType: ...
    @property
    def links(self) -> tuple[Any, ...]: ...
    def accept(self, sock: socket.socket, header: dict[str, str]) -> None: ...
    def accept_datagrams(self, header: dict[str, str], peer_address: tuple[str, int], max_size: int) -> Any: ...
    def connect_in_process(
        self, receiver: DeliveryLoop, uri: str, header: dict[str, str], on_closed: Callable[[Any], None]
    ) -> Source: ...


class SubscriptionInterface(Protocol):
    """The parts of a subscription that the rest of the node uses; see `subscribing.subscription.Subscription`."""

    type: TopicType
    delivery: DeliveryLoop
    change_listeners: list[Callable[[], None]]

    @property
    def links(self) -> tuple[Any, ...]: ...
    def update_publishers(self, uris: list[str], complete: bool = True) -> None: ...
    def has_publisher(self, uri: str) -> bool: ...


class ServiceInterface(Protocol):
    """The parts of a service that the rest of the node uses; see `services.server.ServiceServer`."""

    type: type[Any]
    uri: str

    def call_local(self, request: bytes, header: dict[str, str]) -> bytes: ...


class Context:
    """The context of a node, through which its parts access each other.

    Attributes:
        name: the node's full name.
        loop: the node's loop thread, which never runs user code.
        rpc: calls the APIs of other nodes, on the loop.
        log: the node's log.
        callback_queue: the callback queue of a node that spins; None if callbacks run in the receiving threads.
        environ: environment variables.
        uri: URI of the node's slave API; empty until it is listening.
        address: the addresses to listen on and to advertise; None until they are known.
        allowlist: decides which hosts may connect; None admits all.
        local_key: the common key of the programs that can share memory with the node; empty if none can.
        local_socket_name: returns the name of the Unix socket for these programs, or an empty string if there is none.
        local_room: maximum bytes of messages queued within the process beyond the publisher's ``queue_size``.
        stopping: set when the node starts to shut down, which ends every wait.
        warn_publish_after_shutdown: whether to log the next `publish` after the node has shut down.
        publications: the node's publications by topic; replaced as a whole on changes, so that readers need no lock.
        subscriptions: the node's subscriptions by topic; replaced in the same way.
        services: the node's services by name; replaced in the same way.
    """

    def __init__(
        self,
        name: str,
        loop: Loop,
        rpc: RpcCaller,
        log: Log,
        callback_queue: CallbackQueue | None,
        environ: Mapping[str, str],
        stopping: threading.Event,
    ) -> None:
        self.name = name
        self.loop = loop
        self.rpc = rpc
        self.log = log
        self.callback_queue = callback_queue
        self.environ = environ
        self.uri = ""
        self.address: LocalAddress | None = None
        self.allowlist: Allowlist | None = None
        self.local_key = ""
        self.local_room = 0
        self.local_socket_name: Callable[[], str] = str
        self.stopping = stopping
        self.warn_publish_after_shutdown = True
        self.publications: dict[str, PublicationInterface] = {}
        self.subscriptions: dict[str, SubscriptionInterface] = {}
        self.services: dict[str, ServiceInterface] = {}
        self._unknown_hosts: set[str] = set()
        self._pid = os.getpid()

    @cached_property
    def delivery_threads(self) -> DeliveryThreads:
        """The threads that receive messages; created for the first subscription."""
        return DeliveryThreads(
            self.name,
            lambda error: self.log.exception("internal error in a subscription (please report it)", error=error),
        )

    def close_delivery_threads(self, timeout: float) -> None:
        """Stop the receiving threads, if they exist; wait for them at most ``timeout`` seconds."""
        if "delivery_threads" in self.__dict__:
            self.delivery_threads.close(timeout)

    @property
    def host(self) -> str:
        """The host name or address that the node advertises; empty until it is known."""
        return self.address.advertised if self.address is not None else ""

    def warn_unknown_host(self, topic: str, uri: str, error: UnknownHostError) -> None:
        """Warn that a publisher's host name cannot be resolved; only once per host. Called on the loop."""
        if error.host in self._unknown_hosts:
            return
        if len(self._unknown_hosts) >= MAX_UNKNOWN_HOSTS:
            self._unknown_hosts.clear()
        self._unknown_hosts.add(error.host)
        self.log.warn(
            "no messages of %s from the publisher at %s: %s. %s",
            topic,
            uri,
            error,
            connectivity_hint(error.host, error),
        )

    def log_system_error(self, text: str) -> None:
        """Log an error reported by the operating system. Repetitions are only counted."""
        self.log.peer_event(ERROR, "%s", text)

    def pause(self, seconds: float) -> None:
        """Wait for ``seconds`` of wall time.

        Raises:
            NodeShutdownError: the node is shutting down.
        """
        if self.stopping.wait(seconds):
            raise NodeShutdownError(f"{self.name} is shutting down")

    def check_running(self) -> None:
        """Raise NodeShutdownError if the node is shutting down."""
        if self.stopping.is_set():
            raise NodeShutdownError(f"{self.name} is shutting down")

    @property
    def is_forked(self) -> bool:
        """Whether this process was forked from the node's process; if so, it does not have the node's threads."""
        return os.getpid() != self._pid

    def check_process(self) -> None:
        """Raise NodeError in a forked process, or NodeShutdownError if the node is shutting down."""
        if self.is_forked:
            raise NodeError(
                f"this process was forked from that of {self.name}: create and shut down topics and services in the "
                "original process, or fork before the node starts, and create a node in each process"
            )
        self.check_running()


def find_local_context(uri: str) -> Context | None:
    """Return the context of the node in this process whose slave API has the given URI; None if there is none.

    Nodes in the same process exchange messages without sockets. They find each other through the interpreter's list of
    threads, which contains each node's loop thread, so no separate registry is needed.
    """
    for thread in threading.enumerate():
        if isinstance(thread, LoopThread) and isinstance(thread.owner, Context) and thread.owner.uri == uri:
            return thread.owner
    return None


class HasLinks(Protocol):
    """An object whose links change: a publication or a subscription."""

    context: Context
    change_listeners: list[Callable[[], None]]

    @property
    def links(self) -> tuple[Any, ...]: ...


def wait_for_links(endpoint: HasLinks, count: int, timeout: float | None) -> bool:
    """Wait until a publication or subscription has a minimum number of links.

    Args:
        endpoint: the publication or subscription.
        count: the minimum number of links.
        timeout: maximum number of seconds to wait; None waits until the node shuts down.

    Returns:
        Whether the endpoint has that many links.

    Raises:
        TypeError, ValueError: ``count`` is not a whole number, or ``timeout`` is not a number.
    """
    if not hasattr(type(count), "__index__"):
        raise TypeError(f"count must be a whole number, not {count!r:.80}")
    check_timeout(timeout)
    changed = Event()
    stopping = endpoint.context.stopping
    deadline = None if timeout is None else monotonic() + timeout
    endpoint.change_listeners.append(changed.set)
    try:
        while len(endpoint.links) < count and not stopping.is_set():
            remaining = 0.2 if deadline is None else min(0.2, deadline - monotonic())  # so that a shutdown is noticed
            if remaining <= 0:
                break
            changed.wait(remaining)
            changed.clear()
    finally:
        endpoint.change_listeners.remove(changed.set)
    return len(endpoint.links) >= count
