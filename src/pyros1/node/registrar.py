"""The registrar: registers a node's topics and services with the master, on a separate thread.

All registrations are remembered. If the master was restarted and no longer knows the node, everything is registered
again; stock ROS 1 nodes do not do this (M44).
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable
from time import monotonic
from typing import TYPE_CHECKING, Any, TypeVar, cast

from pyros1.ground.errors import (
    DeadlineError,
    Error,
    MasterError,
    MasterMethodError,
    MasterUnreachableError,
    NodeShutdownError,
    UnknownHostError,
)
from pyros1.net.master_client import MasterClient
from pyros1.net.signal_safe import Condition, Event
from pyros1.node.log.levels import WARN

if TYPE_CHECKING:
    from pyros1.node.context import Context

RETRY_DELAY = 0.2
"""Seconds before the next call to a master that does not respond."""
CHECK_INTERVAL = 3.0
"""Seconds between checks that the node is still registered with the master."""
UNREGISTER_TIMEOUT = 2.0
PING_TIMEOUT = 3.0

Call = tuple[str, ...]  # (method of the master, *arguments)
_T = TypeVar("_T")


class _Job:
    """A call to the master; a thread is waiting for its result.

    Args:
        call: the method to call, and its arguments.
        registration: the registration that the call undoes; None if the call is a registration.
    """

    def __init__(self, call: Call, registration: Call | None = None) -> None:
        self.call = call
        self.registration = registration
        self.done = Event()
        self.value: Any = None
        self.error: Exception | None = None


class Registrar:
    """The node's registrations with the master.

    Args:
        context: the node's context.
        master_uri: the master's URI.
        on_publishers: called with (topic, URIs of its publishers' slave APIs) after a subscription was registered
            again.
        on_restart: called after everything was registered again with a restarted master.
    """

    def __init__(
        self,
        context: Context,
        master_uri: str,
        on_publishers: Callable[[str, list[str]], None],
        on_restart: Callable[[], None],
    ) -> None:
        self._context = context
        self._master = MasterClient(context.name, master_uri, timeout=10.0)
        self._uri = master_uri
        self._on_publishers = on_publishers
        self._on_restart = on_restart
        self._can_be_looked_up = not set(": ") & set(context.name)  # masters refuse to look up names that contain these
        self._registrations: dict[Call, None] = {}
        # Unregistrations to which the master did not respond: after an outage, it may still have the registrations.
        self._pending_unregistrations: dict[Call, None] = {}
        self._jobs: deque[_Job] = deque()
        self._changed = Condition()
        self._closed = False
        self._is_master_unreachable = False
        self._is_outage_logged = False  # whether it has been logged that the master is unreachable
        self._is_incomplete = False  # whether a restarted master still lacks some registrations
        self._thread = threading.Thread(target=self._run, name=f"{context.name}:registrar", daemon=True)

    def start(self) -> None:
        """Start the thread. The node's slave API must be listening."""
        self._thread.start()

    def register(self, method: str, *args: str) -> Any:
        """Register a topic or service. Retry until the master responds; log once that it does not respond.

        Args:
            method: ``registerPublisher``, ``registerSubscriber`` or ``registerService``.
            args: arguments of the method, without the caller id.

        Returns:
            The value returned by the master.

        Raises:
            MasterError: the master refuses.
            NodeShutdownError: the node is shutting down.
        """
        return self.begin_register(method, *args)()

    def begin_register(self, method: str, *args: str) -> Callable[[], Any]:
        """Begin to `register`; return a function that waits for the result. Calls to the master are made in the order
        in which they were begun.
        """
        return self._enqueue(_Job((method, *args)))

    def unregister(self, method: str, *args: str) -> None:
        """Undo `register` with the same arguments.

        It is not an error if the master does not respond or does not have the method, or if the node is shutting down,
        which unregisters everything.
        """
        self.begin_unregister(method, *args)()

    def begin_unregister(self, method: str, *args: str) -> Callable[[], Any]:
        """Begin to `unregister`; return a function that waits until it is done."""
        call = (method, *args)
        return self._enqueue(_Job(_unregistration(call), registration=call))

    def _enqueue(self, job: _Job) -> Callable[[], Any]:
        if self._closed and job.registration is None:
            raise NodeShutdownError(f"{self._context.name} is shutting down")
        self._jobs.append(job)
        self._changed.notify_all()
        return lambda: self._wait(job)

    def _wait(self, job: _Job) -> Any:
        while not job.done.wait(0.5):
            if self._closed and not self._thread.is_alive():
                if job.registration is not None:
                    return None  # `close` unregisters everything
                raise NodeShutdownError(f"{self._context.name} is shutting down")
        if job.error is not None:
            raise job.error
        return job.value

    def close(self) -> None:
        """Unregister everything in one call (T55) and stop the thread."""
        self._closed = True
        self._changed.notify_all()
        if self._thread.ident is not None:
            self._thread.join(UNREGISTER_TIMEOUT)
            if self._thread.is_alive():  # the master does not respond: abort the current call
                self._master.close()
                self._thread.join(UNREGISTER_TIMEOUT)
        if (self._registrations or self._pending_unregistrations) and not self._is_master_unreachable:
            client = MasterClient(self._context.name, self._uri, timeout=UNREGISTER_TIMEOUT)
            try:
                client.multicall(
                    [
                        (call[0], call[1:])
                        for call in (*self._pending_unregistrations, *map(_unregistration, self._registrations))
                    ]
                )
            except Error:
                pass  # the master is gone: nothing to unregister from
            finally:
                client.close()
        self._master.close()

    # On the registrar thread ------------------------------------------------------------------------------------------

    def _run(self) -> None:
        while True:
            self._changed.wait_for(lambda: self._jobs or self._closed, CHECK_INTERVAL)
            closed = self._closed  # read before the queue, so that calls queued before `close` are still made
            job = self._jobs.popleft() if self._jobs else None
            if closed and job is None:
                return
            if job is None:
                try:
                    self._check()
                except Exception as error:  # noqa: BLE001 - caused by a malformed response: the thread must continue
                    self._context.log.internal_error(error)
                continue
            if job.registration is not None:
                self._registrations.pop(job.registration, None)
            try:
                job.value = self._call(job.call)
                if job.call[0] in _UNREGISTER_METHOD_BY_REGISTER_METHOD:
                    self._registrations[job.call] = None
                    self._pending_unregistrations.pop(_unregistration(job.call), None)
            except Exception as error:  # noqa: BLE001 - raised in the waiting thread; this one must continue
                job.error = error
            job.done.set()

    def _call(self, call: Call) -> Any:
        """Call the master and return the result. A registration is repeated until the master responds. If the
        master does not respond to an unregistration, the call is kept for later.
        """
        while True:
            try:
                value = self._call_once(call)
                self._is_master_unreachable = self._is_outage_logged = False
                return value
            except MasterUnreachableError:
                self._is_master_unreachable = True
                if call[0] not in _UNREGISTER_METHOD_BY_REGISTER_METHOD:
                    self._pending_unregistrations[call] = None
                    return 0
                if not self._is_outage_logged:  # `_check` may have noticed the outage before, but does not log it
                    self._is_outage_logged = True
                    self._context.log.warn("the master at %s does not answer; waiting for it to come back", self._uri)
                if self._closed or self._context.stopping.wait(RETRY_DELAY):
                    raise NodeShutdownError(f"{self._context.name} is shutting down") from None
            except Error as error:
                if call[0] in _UNREGISTER_METHOD_BY_REGISTER_METHOD:
                    raise
                self._context.log.debug("%s remains registered: %s", call[1], error)
                return 0

    def _call_once(self, call: Call) -> Any:
        """Call the master and return the result; if the master was restarted, register everything else again as well.

        As soon as a restarted master has this one registration, it knows the node, and `_check` could no longer detect
        that other registrations are missing.
        """
        if (
            not self._registrations
            or call[0] not in _UNREGISTER_METHOD_BY_REGISTER_METHOD
            or not self._can_be_looked_up
        ):
            return self._register_once(call)
        lookup, value = self._master.multicall([("lookupNode", (self._context.name,)), (call[0], call[1:])])
        if isinstance(value, Error):
            value = self._register_with_type(call, value)
        if isinstance(lookup, MasterError) and not isinstance(lookup, MasterMethodError):
            self._reregister_all()
        return value

    def _register_once(self, call: Call) -> Any:
        try:
            return self._master.call(call[0], *call[1:])
        except MasterError as error:
            return self._register_with_type(call, error)

    def _register_with_type(self, call: Call, error: Error) -> Any:
        """Subscribe with the topic's type if the master has refused ``*``, which means any type; return the master's
        response.

        Raises:
            Error: ``error``, if the master has refused for another reason.
        """
        if call[0] == "registerSubscriber" and call[2] == "*" and isinstance(error, MasterError) and not error.code:
            topic_type = dict(cast("Iterable[tuple[str, str]]", self._master.get_topic_types())).get(call[1])
            if topic_type not in (None, "*"):
                return self._master.call(call[0], call[1], topic_type, *call[3:])
        raise error

    def _check(self) -> None:
        """Check whether the node is still registered with the master; if not, register everything again."""
        if not (self._registrations or self._pending_unregistrations) or not self._can_be_looked_up:
            return
        if self._is_incomplete:
            self._reregister_all()
            return
        try:
            self._master.lookup_node(self._context.name)
            self._is_master_unreachable = self._is_outage_logged = False
            for call in list(self._pending_unregistrations):
                self._master.multicall([(call[0], call[1:])])
                self._pending_unregistrations.pop(call, None)
        except MasterUnreachableError:
            self._is_master_unreachable = True
        except MasterMethodError:
            pass  # the master does not have lookupNode: a restart cannot be detected
        except MasterError:  # the master responds, but does not know the node: it was restarted
            self._pending_unregistrations.clear()
            if self._registrations:
                self._reregister_all()
        except Error:
            pass  # an invalid response: try again later

    def _reregister_all(self) -> None:
        if not self._is_incomplete:
            self._context.log.info("the master was restarted: registering again")
        self._is_incomplete = True
        try:
            for call in list(self._registrations):
                try:
                    value = self._register_once(call)
                except MasterUnreachableError:
                    raise
                except MasterError as error:
                    self._context.log.peer_event(WARN, "%s of %s failed: %s", call[0], call[1], error)
                    continue
                if call[0] == "registerSubscriber":
                    self._on_publishers(call[1], value)
            self._on_restart()
            self._is_master_unreachable = self._is_incomplete = False
        except Error as error:  # the next check tries again
            self._is_master_unreachable = isinstance(error, MasterUnreachableError)
            self._context.log.peer_event(WARN, "could not register with the master again, will retry: %s", error)


_UNREGISTER_METHOD_BY_REGISTER_METHOD = {
    "registerPublisher": "unregisterPublisher",
    "registerSubscriber": "unregisterSubscriber",
    "registerService": "unregisterService",
}


def _unregistration(call: Call) -> Call:
    """Return the call that undoes a registration."""
    method, name, *rest = call
    if method == "registerService":  # (service, service_api, caller_api) -> (service, service_api)
        return ("unregisterService", name, rest[0])
    return (
        _UNREGISTER_METHOD_BY_REGISTER_METHOD[method],
        name,
        rest[-1],
    )  # (topic, type, caller_api) -> (topic, caller_api)


def await_master(context: Context, master: MasterClient, timeout: float | None, request: Callable[[float], _T]) -> _T:
    """Repeat a request until the master responds; log once that the node is waiting.

    Args:
        context: the node's context.
        master: the client of the master.
        timeout: maximum number of seconds to wait; None for no limit.
        request: calls the master with the given timeout in seconds; repeated until the master responds.

    Returns:
        The result of ``request``.

    Raises:
        MasterUnreachableError: the master did not respond in time.
        NodeShutdownError: the node is shutting down.
    """
    deadline = None if timeout is None else monotonic() + timeout
    has_warned = False
    while True:
        try:
            return request(PING_TIMEOUT)
        except MasterUnreachableError as error:
            context.check_running()  # Ctrl-C closes the connection to the master
            if deadline is not None and monotonic() >= deadline:
                raise
            reason: object = error.__cause__ if isinstance(error.__cause__, UnknownHostError) else None
            if isinstance(error.__cause__, DeadlineError):
                reason = f"it accepts connections, but did not answer within {PING_TIMEOUT:g} s (was it stopped?)"
        if not has_warned:
            has_warned = True
            context.log.warn(
                "Unable to immediately register with master node [%s]: %s. Will keep trying.",
                master.uri,
                reason or "master may not be running yet",
            )
        context.pause(RETRY_DELAY)
