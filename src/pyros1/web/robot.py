"""The web server's access to the robot: its node, the master, messages, and the log."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from time import monotonic
from typing import Any

from pyros1.graph import Graph
from pyros1.ground.errors import Error, InvalidNameError, MasterError, MessageError, NodeError, ProtocolError
from pyros1.ground.names import FullName
from pyros1.msgs import AnyMsg, load_message
from pyros1.net.master_client import MasterClient
from pyros1.node import Node
from pyros1.web.bags.bag_folders import BagFolders
from pyros1.web.bags.library import Library
from pyros1.web.client_services import ClientServices
from pyros1.web.hub import Hub
from pyros1.web.message_types import MessageTypes
from pyros1.web.package_files import PackageFiles
from pyros1.web.parameters import Parameters
from pyros1.web.publishing import PagePublishers
from pyros1.web.scene.tf_listener import TfListener
from pyros1.web.server.access import Access
from pyros1.web.server.wire import RequestError
from pyros1.web.system import System
from pyros1.web.transforms.console import Console

RETRY_DELAY = 1.0
"""Seconds between attempts to find a master."""
_MAX_TOPICS_AGE = 0.5
"""Seconds for which the master's list of topics is cached."""
_SMALL_QUEUE, _MEDIUM_QUEUE, _LARGE_QUEUE = 10, 100, 2_000
"""Maximum number of messages queued for slow views, in this order: for topics with images or point clouds, for topics
of unknown types, and for all other topics.
"""
_CONNECT_TIMEOUT = 0.5
"""Maximum number of seconds to wait for existing publishers to connect."""
_CALLER_ID = "/pyros1_web"


class Robot:
    """Access to the robot. There may be no master yet; if the master is lost, access resumes when it is back.

    Args:
        master_uri: URI of the master.
        access: the access rules for pages.
        make_node: creates the server's node; raises MasterUnreachableError, without waiting, if no master responds.
        has_console: whether log messages are collected, for pages that show them.

    Attributes:
        joint_publishers: topic -> the view that publishes joint states on it; only one view may do so at a time.
        gamepads: topic -> the view that publishes a page's gamepad on it; likewise, only one per topic.
        on_killed: called, from any thread, when another program has shut down the server's node.
    """

    def __init__(
        self, master_uri: str, access: Access, make_node: Callable[[], Node], has_console: bool = True
    ) -> None:
        self.master_uri = master_uri
        self.access = access
        self.master = MasterClient(_CALLER_ID, master_uri, timeout=3.0)
        self.graph: Graph = _CachedGraph(self.master)
        self.system = System(self.graph)
        self.parameters = Parameters(self.master, access.for_parameters, access.for_parameters.check_visible)
        self.console = Console()
        self.tf_listener = TfListener(self.listen)
        self.files = PackageFiles()
        self.bags = Library(BagFolders(access.bags, access.granted), access.may_see)
        self.joint_publishers: dict[str, object] = {}
        self.gamepads: dict[str, object] = {}
        self.problem = "looking for the master"
        self.on_killed: Callable[[], object] = lambda: None
        self._make_node = make_node
        self._has_console = has_console
        self._node: Node | None = None
        self._closed = threading.Event()
        self._node_found = threading.Event()
        self._hub = Hub(self._subscribe, self._now, wait_for_publishers=self._wait_for_publishers)
        self.types = MessageTypes(self.listen)
        self.publishers = PagePublishers(lambda: self.node, self.types.find)
        self.client_services = ClientServices(lambda: self.node)
        self._thread = threading.Thread(target=self._search_for_master, name="web: search for the master", daemon=True)

    def start(self) -> None:
        """Start a thread that looks for the master and then creates the server's node."""
        self._thread.start()

    @property
    def node(self) -> Node:
        """The server's node.

        Raises:
            RequestError: the node does not exist yet, or has been shut down; the message says why.
        """
        if self._node is None or self.problem:
            raise RequestError(self.problem)
        return self._node

    def wait_for_node(self, timeout: float | None = None) -> bool:
        """Wait until the server's node exists; return whether it does.

        Args:
            timeout: maximum number of seconds to wait; None for no limit.
        """
        return self._node_found.wait(timeout)

    def listen(self, topic: str, listener: Any, on_ready: Callable[[], object] | None = None) -> Callable[[], None]:
        """Call a listener with each message on a topic; see `Hub.listen`.

        Raises:
            RequestError: there is no master yet, or pages are not allowed to see the topic.
        """
        self.check_running()
        try:
            name = self.full_name(topic)
        except InvalidNameError:  # another node may have advertised such a name; no messages arrive from it
            name = FullName(topic)
        self.check_visible(name)
        return self._hub.listen(name, listener, on_ready)

    def full_name(self, name: str) -> FullName:
        """Return the full form of a name that a client sent, with the server's remappings applied once.

        Raises:
            InvalidNameError: the name is invalid.
            RequestError: there is no master yet.
        """
        return FullName(self.node.resolve(name))

    def type_of(self, topic: str, expected_type: str = "") -> str:
        """Return the type of a topic; ``*`` if it is unknown.

        The cached type is used only if it is known and the expected one. Otherwise, the master is queried again, since
        another client may just have advertised the topic.

        Args:
            topic: the topic's full name.
            expected_type: the expected type; empty if any type will do.

        Raises:
            MasterUnreachableError: the master does not respond.
        """
        type_name = self.graph.topic_types().get(topic, "*")
        if type_name == "*" or type_name != (expected_type or type_name):
            type_name = Graph(self.master).topic_types().get(topic, "*")
        return type_name

    def master_problem(self) -> str:
        """Return why the master does not respond; empty if it does."""
        try:
            self.graph.topic_types()
        except Error as error:
            return str(error)
        return ""

    def check_running(self) -> None:
        """Check that the server is still running.

        Raises:
            RequestError: the server is shutting down.
        """
        if self._closed.is_set():
            raise RequestError("the server is shutting down")

    def check_visible(self, name: str) -> None:
        """Check that pages may see a topic, service or parameter.

        Raises:
            RequestError: pages are not allowed to see the name.
        """
        self.access.check_visible(name)

    def check_service_visible(self, name: str) -> None:
        """Check that clients may see a service, if the rules for services differ from those for topics.

        Raises:
            RequestError: clients are not allowed to see the service.
        """
        self.access.for_services.check_visible(name)

    def clean_up(self) -> None:
        """Close publishers that have not been used for a while. Must be called periodically."""
        self.publishers.clean_up()

    def close(self) -> None:
        """Close everything, and end waits for an unreachable master. May be called repeatedly."""
        self._closed.set()
        self.master.close()
        if self._node is not None:
            self._node.shutdown()  # first, since this ends whatever other threads are waiting for
        if self._thread.is_alive():
            self._thread.join(5)
        if self._node is not None:
            self._node.shutdown()  # in case it was created meanwhile
        self.bags.close()
        self._hub.close()
        self.publishers.close()

    def _search_for_master(self) -> None:
        while not self._closed.is_set():
            try:
                node = self._make_node()
            except (MasterError, ProtocolError) as error:
                self.problem = f"no ROS master at {self.master_uri}: start one with: pyros1 core"
                if isinstance(error, ProtocolError):
                    self.problem = str(error)
                self._closed.wait(RETRY_DELAY)
                continue
            except (Error, OSError) as error:
                self.problem = f"the server's node cannot start: {error}"
                self._closed.wait(RETRY_DELAY)
                continue
            try:
                with suppress(NodeError):  # it was shut down while the master was unreachable
                    if self._has_console:
                        self.console.start(node)
            except OSError as error:  # for example, no more files can be opened
                self.problem = f"the server's node cannot start: {error}"
                node.shutdown(self.problem)
                self._closed.wait(RETRY_DELAY)
                continue
            self._node, self.problem = node, ""
            with suppress(NodeError):
                node.on_shutdown(self._on_node_shutdown)
            self._node_found.set()
            return

    def _subscribe(self, topic: str, callback: Callable[[AnyMsg], object]) -> Any:
        # The queue is bounded, so that a slow view does not delay the robot's publishers.
        return self.node.subscribe(topic, AnyMsg, callback, queue_size=self._queue_size(topic))

    def _on_node_shutdown(self) -> None:
        if not self._closed.is_set():
            self.problem = "the server's node was requested to shut down"
            self.on_killed()

    def _wait_for_publishers(self, topic: str, subscriber: Any) -> None:
        publishers = self.graph.state().publishers.get(topic, ())
        subscriber.wait_for_publishers(len(publishers), _CONNECT_TIMEOUT)

    def _queue_size(self, topic: str) -> int:
        try:
            type_name = self.graph.topic_types().get(topic, "")
            return _SMALL_QUEUE if "uint8[]" in load_message(type_name)._full_text else _LARGE_QUEUE
        except (MasterError, ProtocolError, MessageError):
            return _MEDIUM_QUEUE

    def _now(self) -> float:
        return self._node.now().to_sec() if self._node else 0.0


class _CachedGraph(Graph):
    """Caches the list of topics briefly, since many plotted curves may look up their topics at once."""

    def __init__(self, master: MasterClient) -> None:
        super().__init__(master)
        self._lock = threading.Lock()
        self._types: dict[str, str] = {}
        self._error: Error | None = None
        self._queried_at = float("-inf")

    def topic_types(self) -> dict[str, str]:
        with self._lock:
            if monotonic() - self._queried_at >= _MAX_TOPICS_AGE:
                try:
                    self._types, self._error = super().topic_types(), None
                except Error as error:
                    self._error = error
                self._queried_at = monotonic()
            if self._error is not None:
                raise self._error
            return self._types
