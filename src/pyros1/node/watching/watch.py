"""Watches one node: polls it and the master periodically, on the loop, and reports changes."""

from __future__ import annotations

import errno
from collections.abc import Callable
from functools import partial
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.ground import terminal_text
from pyros1.ground.errors import DeadlineError, Error, XmlRpcFault
from pyros1.node.watching.liveness import Sighting, State, WatchedNode

if TYPE_CHECKING:
    from pyros1.net.loop import Loop
    from pyros1.net.rpc_caller import RpcCaller
    from pyros1.node.watching.lookups import Lookups

RETRY_DELAY = 0.1
"""Seconds until the next request to a node that could not be reached, but may still be running."""
MIN_STALL = 0.25
"""If a timer fires more than this many seconds late, this process was suspended, and the missing response is ignored.
"""


class Watch:
    """A watched node; created by ``Node.watch``. As a context manager, it stops watching on exit.

    Args:
        loop: the node's loop.
        rpc: calls the watched nodes, and only these: a hanging node could delay other calls.
        lookups: looks up addresses with the master.
        caller_id: full name of the watching node.
        name: full name of the watched node.
        period: seconds between requests.
        limit: maximum response time in seconds.
        notify: called on the loop with each `Sighting`.
        on_close: called with this object when it is closed.
    """

    def __init__(
        self,
        loop: Loop,
        rpc: RpcCaller,
        lookups: Lookups,
        caller_id: str,
        name: str,
        period: float,
        limit: float,
        notify: Callable[[Sighting], object],
        on_close: Callable[[Watch], object],
    ) -> None:
        self.period = period
        self.last: Sighting | None = None
        self.closed = False
        self._loop = loop
        self._rpc = rpc
        self._lookups = lookups
        self._caller_id = caller_id
        self._node = WatchedNode(name, limit)
        self._notify = notify
        self._on_close = on_close
        self._is_request_pending = False
        self._has_requested_early = False  # whether `on_disconnected` has sent a request in this period
        self._was_stall_ignored = False  # whether a missing response was ignored since the last response

    # For the program --------------------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """Full name of the watched node."""
        return self._node.name

    @property
    def state(self) -> State:
        """The node's current state; UNSEEN if it has not responded since the watch was started."""
        return self._node.state

    @property
    def alive(self) -> bool:
        """Whether the node is running, which means that it was found and has not been lost since."""
        return self._node.state is State.FOUND

    def close(self) -> None:
        """Stop watching. A running callback continues. Thread-safe, and allowed in signal handlers."""
        if not self.closed:
            self.closed = True
            self._on_close(self)

    def __enter__(self) -> Watch:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # On the loop ------------------------------------------------------------------------------------------------------

    def poll(self) -> None:
        """Ask the master for the node's address, and the node for its process id; called once per period."""
        if self.closed:
            return
        self._has_requested_early = False
        self._lookups.look_up(self.name, self._on_address)
        self._request_pid()

    def on_disconnected(self, uri: str) -> None:
        """Send a request immediately, since the node has closed a connection and may have exited."""
        if uri == self._node.uri and not self._has_requested_early:
            self._has_requested_early = True
            self._request_pid()

    def _on_address(self, uri: str) -> None:
        if self.closed:
            return
        previous_uri = self._node.uri
        self._report(self._node.on_address(uri, monotonic()))
        if uri != previous_uri:
            self._is_request_pending = False  # a response from the old address is ignored
            self._request_pid()

    def _request_pid(self) -> None:
        now = monotonic()
        uri, remaining_time = self._node.uri, self._node.remaining_time(now)
        if self.closed or self._is_request_pending or not uri:
            return
        self._is_request_pending = True
        on_reply = partial(self._on_pid, uri, now, remaining_time)
        self._rpc.call(uri, "getPid", (self._caller_id,), on_reply, max(0.001, remaining_time))

    def _on_pid(self, uri: str, requested_at: float, remaining_time: float, reply: Any, error: Error | None) -> None:
        if self.closed or uri != self._node.uri:
            return
        if error is None or isinstance(error, XmlRpcFault):  # a node that does not have getPid is running as well
            self._handle_pid(uri, requested_at, _parse_pid(reply))
        else:
            self._is_request_pending = False
            self._handle_failure(error, requested_at, remaining_time)

    def _handle_pid(self, uri: str, requested_at: float, pid: int | None) -> None:
        if not self._node.is_new_process(pid):
            self._is_request_pending = False
            self._was_stall_ignored = False
            self._report(self._node.on_response(pid, monotonic()))
            return
        # If the node has exited, another node may be using its port.
        on_reply = partial(self._on_name, uri, requested_at, pid)
        self._rpc.call(uri, "getName", (self._caller_id,), on_reply, max(0.001, self._node.remaining_time(monotonic())))

    def _on_name(self, uri: str, requested_at: float, pid: int | None, reply: Any, error: Error | None) -> None:
        if self.closed or uri != self._node.uri:
            return
        self._is_request_pending = False
        name = reply[2] if isinstance(reply, list) and len(reply) == 3 and reply[0] == 1 else None
        now = monotonic()
        if isinstance(name, str) and name != self.name:
            reason = f"{terminal_text.one_line(name)} answers in its place"
            self._report(self._node.on_failure(reason, requested_at, now, is_port_closed=True))
        elif error is None or isinstance(error, XmlRpcFault):  # stock roscpp does not report its name
            self._was_stall_ignored = False
            self._report(self._node.on_response(pid, now))
        else:
            self._handle_failure(error, requested_at, self._node.remaining_time(requested_at))

    def _handle_failure(self, error: Error, requested_at: float, remaining_time: float) -> None:
        now = monotonic()
        if (
            isinstance(error, DeadlineError)
            and now > requested_at + remaining_time + MIN_STALL
            and not self._was_stall_ignored
        ):
            self._was_stall_ignored = True
            self._node.ignore_failure()
            self._request_pid()
            return
        self._report(self._node.on_failure(str(error), requested_at, now, _is_port_closed(error)))
        if self.alive and not isinstance(error, DeadlineError):
            self._loop.call_later(RETRY_DELAY, self._request_pid)

    def _report(self, changes: list[Sighting]) -> None:
        for sighting in changes:
            self.last = sighting
            if not sighting.alive:
                self._lookups.look_up(self.name, self._on_address)  # another node of this name may be running already
            self._notify(sighting)


def _parse_pid(reply: Any) -> int | None:
    """Return the process id in a reply to ``getPid``; None if there is none."""
    if isinstance(reply, list) and len(reply) == 3 and reply[0] == 1 and isinstance(reply[2], int):
        return reply[2]
    return None


def _is_port_closed(error: Error) -> bool:
    """Return whether an error means that the node's machine has refused the connection."""
    return isinstance(error.__cause__, OSError) and error.__cause__.errno == errno.ECONNREFUSED
