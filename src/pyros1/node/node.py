"""The Node class, through which a program participates in the ROS graph (https://wiki.ros.org/Nodes)."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Literal

from pyros1.ground import names, terminal_text
from pyros1.ground.errors import Error, NodeError, NodeShutdownError, SettingError
from pyros1.msgs import load_message
from pyros1.net.hosts import addresses_from_environment
from pyros1.net.hosts import master_uri as find_master_uri
from pyros1.net.loop import Loop
from pyros1.net.master_client import MasterClient
from pyros1.net.rpc_caller import RpcCaller
from pyros1.net.signal_safe import Event
from pyros1.net.xmlrpc_server import XmlRpcServer
from pyros1.node import checks
from pyros1.node.callback_queue import CallbackQueue
from pyros1.node.clock import Clock, TimeMethods, Timers
from pyros1.node.context import Context
from pyros1.node.identity import namespace_and_name
from pyros1.node.log.levels import WARN, level_from_name
from pyros1.node.log.logger import Log
from pyros1.node.log.services import offer_log
from pyros1.node.log.sink import LogSink, default_log_file
from pyros1.node.parameters.parameters import Parameters
from pyros1.node.parameters.private import argument_warnings, leftover_warning, set_private
from pyros1.node.registrar import Registrar, await_master
from pyros1.node.same_host import local_key
from pyros1.node.server import TcprosServer, open_ports
from pyros1.node.services.methods import ServiceMethods, Services
from pyros1.node.shutdown import Shutdown
from pyros1.node.slave import SlaveApi
from pyros1.node.topics import MAX_CALLBACK_WAIT, TopicMethods, Topics
from pyros1.node.watching.notifiers import Notifiers
from pyros1.node.watching.watches import Watches

if TYPE_CHECKING:
    from pyros1.node.watching.liveness import Sighting
    from pyros1.node.watching.watch import Watch

_Ports = tuple[int, int]
_INTERRUPTED_EXIT_CODE = 130


class Node(TopicMethods, ServiceMethods, TimeMethods):
    """A ROS node. As a context manager, it shuts down on exit.

    A process may have several nodes; they exchange messages without sockets.

    Args:
        name: base name, without namespace. ``__name:=`` on the command line replaces it.
        anonymous: whether to make the name unique by appending the process id and the time.
        namespace: the namespace, such as ``/robot1``; None for the value of ROS_NAMESPACE. ``__ns:=`` on the command
            line takes precedence.
        argv: command-line arguments with remappings, without the program's name; None for ``sys.argv[1:]``.
        callbacks: "inline" runs callbacks as messages arrive, each topic in its own thread (like rospy); "spin" queues
            them until the program calls `spin` or `spin_once` (like roscpp).
        master_uri: URI of the master; None for ``__master:=``, ROS_MASTER_URI or http://localhost:11311.
        environ: environment variables; None for those of the process.
        log_level: the minimum level that is logged: debug, info, warn, error or fatal.
        handle_signals: whether SIGINT and SIGTERM shut the node down; only possible if the node is created in the main
            thread.
        rosout: whether to publish the log on /rosout.
        log_services: whether to offer the services get_loggers and set_logger_level.
        wait_for_master: maximum number of seconds to wait for a master that does not respond; None for no limit.
        wall_time: whether to ignore /use_sim_time.
        ports: the port of the slave API (XML-RPC), and the port of topics and services (TCPROS); 0 for any.
        strict_names: whether to refuse names that break the naming rules, and to log private parameters left by an
            earlier run and messages published after the shutdown.
        local_room: maximum bytes of messages queued for a slow subscriber in the same process beyond the publisher's
            ``queue_size``; between processes, the sockets buffer about 1 MB.

    Raises:
        InvalidNameError: the name is not legal.
        MasterUnreachableError: no master responded within ``wait_for_master`` seconds.
        MasterError: the master refuses the node.
        NodeError: the node cannot listen on its address, or its ports are in use.
        SettingError: PYROS1_ALLOW, PYROS1_BIND, PYROS1_PORTS or ``__priority:=`` is invalid.
        ProtocolError: the master's URI is not valid, or the program that responds is not a master.
        SystemExit: SIGINT or SIGTERM was received before the node had started.
    """

    def __init__(
        self,
        name: str,
        *,
        anonymous: bool = False,
        namespace: str | None = None,
        argv: Sequence[str] | None = None,
        callbacks: Literal["inline", "spin"] = "inline",
        master_uri: str | None = None,
        environ: Mapping[str, str] | None = None,
        log_level: str = "info",
        handle_signals: bool = True,
        rosout: bool = True,
        log_services: bool = True,
        wait_for_master: float | None = None,
        wall_time: bool = False,
        ports: _Ports = (0, 0),
        strict_names: bool = True,
        local_room: int = 0,
    ) -> None:
        argv = checks.check_node(name, namespace, argv, master_uri, environ, wait_for_master, ports)
        if callbacks not in ("inline", "spin"):
            raise ValueError(f'callbacks must be "inline" or "spin", not {callbacks!r}')
        self.environ = environ = os.environ if environ is None else environ
        self.arguments = names.parse_arguments(list(sys.argv[1:] if argv is None else argv))
        special = self.arguments.special
        self.namespace, self.name = namespace_and_name(name, anonymous, namespace, special, environ, strict_names)
        self._strict = strict_names
        self._remappings = self.arguments.resolved_remappings(self.name, strict_names)
        self.master_uri = master_uri or find_master_uri(environ, special)

        level = level_from_name(log_level)
        key = local_key(environ)
        self.master = MasterClient(self.name, self.master_uri)
        # The loop is created after all arguments have been validated: it has sockets, which only `shutdown` closes.
        stopping = Event()
        self._clock = Clock(stopping)
        log_file = default_log_file(self.name, environ, special)
        loop = Loop(f"{self.name}:loop", on_error=lambda error: self.log.internal_error(error))  # noqa: PLW0108 - log does not exist yet
        self._sink = LogSink(self.name, environ, log_file, self._clock.now_and_is_simulated, loop.call_later)
        self.log = Log(self._sink, level=level)
        self._callback_queue = CallbackQueue() if callbacks == "spin" else None
        self._context = Context(
            self.name, loop, RpcCaller(loop), self.log, self._callback_queue, environ, stopping=stopping
        )
        self._context.local_key, self._context.local_room = key, local_room
        self._context.warn_publish_after_shutdown = strict_names
        loop.thread.owner = self._context
        self._topics = Topics(self._context, lambda: self._registrar)
        self._services = Services(self._context, lambda: self._registrar, self._service_uri)
        self._timers = Timers(self._clock, self._callback_queue, self.log)
        self._notifiers = Notifiers(self.log, self._callback_queue)
        self._watches = Watches(self._context, self.master_uri, self._notifiers)
        self._shutdown = Shutdown(self._context, self._clock, self._close)
        notify, remappings = self._notifiers.make("changes of parameters").notify, self.arguments.remappings
        self.params = Parameters(self.master, self.resolve, lambda: self.uri, remappings, loop.call_soon, notify)
        self._registrar = Registrar(
            self._context, self.master_uri, self._topics.on_publishers_found, self.params.refetch
        )
        self._slave: XmlRpcServer | None = None
        self._tcpros: TcprosServer | None = None
        loop.start()
        try:
            self._open(wait_for_master, handle_signals, wall_time, ports)
            self._offer_log(rosout, log_services)
        except BaseException as error:
            self.shutdown("the node could not start")
            if isinstance(error, Error) and self._shutdown.signalled:
                raise SystemExit(_INTERRUPTED_EXIT_CODE) from None  # Ctrl-C while waiting for the master
            raise

    # Starting ---------------------------------------------------------------------------------------------------------

    def _open(self, timeout: float | None, handle_signals: bool, wall_time: bool, ports: _Ports) -> None:
        self._context.address = address = addresses_from_environment(self.environ, self.arguments.special)
        self._host = address.advertised
        self._shutdown.watch(handle_signals)
        if "__priority" in self.arguments.special:
            self._apply_priority_argument()
        for warning in (*address.warnings, *argument_warnings(self.arguments)):
            self.log.warn("%s", warning)
        slave = SlaveApi(
            self._context,
            self.master_uri,
            lambda: (self._host, self._tcpros.port if self._tcpros else 0),
            lambda: self.params,
            self._on_shutdown_request,
        )
        self._tcpros, self._slave = open_ports(
            self._context, address, lambda: self._services.servers, slave.dispatch, ports
        )
        self._context.uri = self._slave.uri
        use_sim_time, private_params = await_master(
            self._context,
            self.master,
            timeout,
            lambda limit: set_private(self.master, self.resolve, self.arguments.parameters, limit),
        )
        if self._strict and "__log" not in self.arguments.special:  # launchers pass __log and set parameters themselves
            for line in leftover_warning(self.name, private_params, self.arguments.parameters):
                self.log.info("%s", terminal_text.one_line(line, 10_000))
        self._registrar.start()
        if use_sim_time is True and not wall_time:
            self._use_simulated_time()

    def _offer_log(self, rosout: bool, services: bool) -> None:
        parts = (self.log, self._sink, self.name, self._topics, self._services, self.resolve)
        offer_log(*parts, rosout, services, self._strict)

    def _service_uri(self) -> str:
        return self._tcpros.uri if self._tcpros else ""

    def _use_simulated_time(self) -> None:
        self._clock.use_simulated_time()
        clock = load_message("rosgraph_msgs/Clock")
        self._topics.subscribe("/clock", clock, lambda message: self._clock.tick(message.clock), 1, direct=True)

    def _apply_priority_argument(self) -> None:
        from pyros1.ground.realtime import check_priority  # noqa: PLC0415 - few nodes need it

        try:
            priority = check_priority(self.arguments.special["__priority"], "__priority:=")
        except ValueError as error:
            raise SettingError(str(error)) from error
        try:
            self.realtime(priority)
        except NodeError as error:  # the same launch file must start on a developer's machine
            self.log.warn("%s. The node runs without it", error)

    # Names ------------------------------------------------------------------------------------------------------------

    @property
    def uri(self) -> str:
        """The URI of the node's slave API."""
        return self._context.uri

    def resolve(self, name: str, *, remap: bool = True) -> str:
        """Resolve a name as this node sees it, and return the full name.

        Libraries that have several topics below a common name should first resolve that name with this method and then
        append to the result: a remapping of the common name then affects all topics, and a remapping of the full name
        of a topic affects only that topic.

        Args:
            name: relative, global or private (``~x``).
            remap: whether to apply remappings.

        Raises:
            InvalidNameError: ``name`` is not a legal name.
        """
        checks.check_text(name, "the name")
        return names.resolve_name(name, self.name, self._remappings if remap else None, self._strict)

    # Other nodes ------------------------------------------------------------------------------------------------------

    def watch(
        self,
        name: str,
        on_lost: Callable[[Sighting], object] | None = None,
        on_found: Callable[[Sighting], object] | None = None,
        *,
        period: float = 0.5,
        limit: float = 1.0,
    ) -> Watch:
        """Watch another node, of any client library: be notified when it dies, hangs, is replaced, or comes back.

        If the node's process exits while its machine keeps running, this is noticed immediately, because the connection
        is closed. A stopped process (SIGSTOP, a debugger) and a machine that is down or disconnected are noticed within
        ``period + limit`` seconds. A node whose callbacks hang while its process runs still responds; to notice that,
        use ``deadline`` of `subscribe`. As long as the node responds, it does not matter whether the master responds or
        was restarted.

        Args:
            name: the node's name.
            on_lost: called like any callback, with a Sighting, when the node is lost after it was found.
            on_found: called like any callback, with a Sighting, when the node is found for the first time, or again.
            period: seconds of wall time between requests to the node (getPid) and to the master.
            limit: maximum response time, in seconds of wall time. A busy machine needs a longer limit than an idle one.

        Returns:
            The watch, with ``state``, ``alive``, ``last`` and ``close()``.

        Raises:
            InvalidNameError: ``name`` is not a legal name.
            NodeShutdownError: the node is shutting down.
            TypeError, ValueError: an argument is invalid.
        """
        checks.check_name(name, "watch(name)")
        return self._watches.start(self.resolve(name), on_lost, on_found, period, limit)

    # Lifecycle --------------------------------------------------------------------------------------------------------

    def ok(self) -> bool:
        """Return whether the node is running: False as soon as it starts to shut down."""
        return not self._context.stopping.is_set()

    def spin(self) -> None:
        """Run callbacks until the node shuts down; in a node with inline callbacks, only wait until it does."""
        if self._callback_queue is None:
            self._context.stopping.wait()
            return
        while not self._context.stopping.is_set():
            self.spin_once(0.5)

    def spin_once(self, timeout: float = 0.0) -> int:
        """Run the callbacks that are currently queued.

        Args:
            timeout: maximum number of seconds to wait if none is queued.

        Returns:
            The number of callbacks that were run; 0 in a node with inline callbacks.
        """
        checks.check_seconds(timeout, "timeout")
        if self._callback_queue is None:
            return 0
        self._callback_queue.wait(timeout)
        return self._callback_queue.run_available()

    def realtime(self, priority: int) -> None:
        """Give the program a real-time priority (SCHED_FIFO): it runs as soon as it has work, even on a busy machine.

        This applies to all threads of the process, and to the processes that it starts. A program that never pauses
        then blocks all others on its processor. ``__priority:=50`` on the command line does the same, but only logs a
        warning if it is not permitted.

        Args:
            priority: 1 to 99; programs with a higher priority run first; 0 for none.

        Raises:
            ValueError: the priority is not a whole number from 0 to 99.
            NodeError: the system does not support real-time priorities, or the user may not set them.
        """
        from pyros1.ground.realtime import check_priority, set_priority  # noqa: PLC0415 - few nodes need it

        set_priority(check_priority(priority, "realtime(priority)"), os.getpid())

    def on_shutdown(self, hook: Callable[[], object], early: bool = False) -> None:
        """Call ``hook`` when the node starts to shut down. Hooks can still publish.

        Args:
            hook: the function to call, without arguments.
            early: whether to call it before all other hooks, while everything still works: `ok` returns True, sleeps
                are not interrupted, and services respond.
        """
        checks.check_callback(hook, "on_shutdown(hook)", "hook")
        self._shutdown.on_shutdown(hook, early)

    def shutdown(self, reason: str = "") -> None:
        """Shut down the node: run the hooks, unregister and close everything. Thread-safe, and allowed in signal
        handlers.

        Args:
            reason: the reason to log.
        """
        self._shutdown.end(reason)

    def _close(self) -> None:
        loop = self._context.loop
        self._timers.shutdown()
        self._watches.close()
        self._registrar.close()
        self._services.close()
        self._topics.close()
        self._notifiers.close(MAX_CALLBACK_WAIT)
        self._timers.join(1.0)
        self.master.close()
        self._context.rpc.close()
        if self._slave is not None:
            self._slave.close()
        if self._tcpros is not None:
            loop.call_soon(self._tcpros.close)
        loop_drained = threading.Event()
        loop.call_soon(loop_drained.set)
        loop_drained.wait(2.0)  # the loop makes the calls queued above first, especially those that close sockets
        loop.stop()
        self._sink.close()

    def _on_shutdown_request(self, reason: str) -> None:
        if reason:
            self.log.peer_event(WARN, "shutdown request: %s", reason)
        self._shutdown.request(reason)

    def __enter__(self) -> Node:
        return self

    def __exit__(self, error_class: type[BaseException] | None, *_: object) -> bool:
        self.shutdown()
        # Suppress the exception of a wait that the shutdown has interrupted.
        return error_class is not None and issubclass(error_class, NodeShutdownError)
