"""Both ends of service calls in a bridge in the dialect of zenoh-plugin-ros1: other bridges' services provided on this
master, and this master's services that others call. Requests and responses stay encoded.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any

from pyros1.bridge.plugin_ros1.keys import Resource
from pyros1.bridge.plugin_ros1.plan import TakenResource
from pyros1.bridge.plugin_ros1.responses import Responses
from pyros1.bridge.plugin_ros1.session import CALL_TIME, PluginSession
from pyros1.ground.errors import Error, ServiceError, ServiceRefusal
from pyros1.ground.names import FullName
from pyros1.ground.terminal_text import one_line
from pyros1.msgs import AnyMsg, Service
from pyros1.node import Node
from pyros1.node.services.server import ServiceServer
from pyros1.node.services.workers import Workers

MAX_CALLS = 64
"""Maximum number of calls from elsewhere in progress; more are refused."""
MAX_REQUEST = 64 << 20
_CLOSE_TIME = 1.0


def raw_service(type_name: str, md5sum: str) -> type[Service]:
    """Return a service class whose requests and responses stay encoded."""
    parts = {
        f"_{part.lower()}_class": type(part, (AnyMsg,), {"__slots__": [], "_type": type_name + part})
        for part in ("Request", "Response")
    }
    return type("RawService", (Service,), {"_type": type_name, "_md5sum": md5sum, "_full_text": "", **parts})


class CallCount:
    """Counts a service's calls and failed calls, and keeps the last error.

    Attributes:
        calls, errors, last_error: the two counts and the last error.
        note: a remark for the status.
    """

    def __init__(self) -> None:
        self.note = ""
        self.calls = 0
        self.errors = 0
        self.last_error = ""


class PluginServices:
    """The services of a bridge.

    Args:
        node: the bridge's node.
        session: its zenoh session.
        key: returns the key of a service's calls.
    """

    def __init__(self, node: Node, session: PluginSession, key: Callable[[Resource], str]) -> None:
        self._node = node
        self._session = session
        self._key = key
        self._provided: dict[str, tuple[tuple[str, ...], ServiceServer]] = {}
        self._served: dict[str, tuple[Resource, str]] = {}  # by key: the service, and its local name
        self._workers = Workers(f"{node.name}:call", MAX_CALLS)
        self._counts: dict[tuple[str, str], CallCount] = {}
        self._lock = threading.Lock()

    def count(self, kind: str, local: str) -> CallCount:
        """Return the count of a service, by its local name.

        Args:
            kind: ``calls`` for a service of another bridge, ``serves`` for one that is served here.
            local: the service's local name.
        """
        with self._lock:
            return self._counts.setdefault((kind, local), CallCount())

    def adjust(self, serves: Mapping[Resource, str], calls: Mapping[str, TakenResource]) -> dict[str, Error]:
        """Serve and provide exactly these services from now on. This waits for the master.

        Returns:
            The errors of services that could not be provided, by local name.
        """
        self._served = {self._key(resource): (resource, local) for resource, local in serves.items()}
        with self._lock:
            wanted = {("serves", local) for local in serves.values()} | {("calls", local) for local in calls}
            self._counts = {name: count for name, count in self._counts.items() if name in wanted}
        wanted_keys = {local: self._target(taken) for local, taken in calls.items()}
        failed: dict[str, Error] = {}
        for local, (target, server) in [*self._provided.items()]:
            if wanted_keys.get(local) != target:
                del self._provided[local]
                server.shutdown()
        for local, taken in calls.items():
            if local not in self._provided:
                try:
                    self._provided[local] = (wanted_keys[local], self._provide(local, taken))
                except Error as error:
                    failed[local] = error
        return failed

    def _target(self, taken: TakenResource) -> tuple[str, ...]:
        return (taken.type, self._key(taken.sources[0]))

    # Calls from here --------------------------------------------------------------------------------------------------

    def _provide(self, local: str, taken: TakenResource) -> ServiceServer:
        responses = Responses(taken.type, taken.md5sum)
        if not responses.is_known:
            self.count("calls", local).note = "its type is not installed here, so errors may look like responses"
        handler = partial(self._call_elsewhere, local, self._key(taken.sources[0]), responses)
        return self._node.advertise_service(FullName(local), raw_service(taken.type, taken.md5sum), handler)

    def _call_elsewhere(self, local: str, key: str, responses: Responses, request: AnyMsg) -> AnyMsg:
        """Call a service elsewhere, and return its response. Called in the service's thread.

        Raises:
            ServiceRefusal: the call failed.
        """
        count = self.count("calls", local)
        count.calls += 1
        try:
            body = self._session.call(key, bytes(request._buff))
            error = responses.error(body)
            if error is not None:
                raise ServiceRefusal(error)
        except ServiceRefusal as refusal:
            count.errors += 1
            count.last_error = str(refusal.args[0])
            raise
        return AnyMsg(body)

    # Calls from elsewhere ---------------------------------------------------------------------------------------------

    def on_call(self, key: str, query: Any) -> None:
        """Answer a query later. Called on zenoh's threads."""
        found = self._served.get(key)
        if found is None or query.payload is None or len(query.payload) > MAX_REQUEST:
            query.reply_err(b"the bridge does not take this call")
        elif not self._workers.submit(partial(self._answer, *found, query)):
            query.reply_err(b"the bridge has too many calls at once")

    def _answer(self, resource: Resource, local: str, query: Any) -> None:
        """Call a service of this master, and answer the query. The plugin itself sends an error's text as if it were a
        response, but it also understands error replies, and its callers then get an error.
        """
        count = self.count("serves", local)
        count.calls += 1
        try:
            with self._node.service(FullName(local), raw_service(resource.type, resource.md5sum)) as client:
                response = client.call(AnyMsg(query.payload.to_bytes()), CALL_TIME)
            query.reply(query.key_expr, bytes(response._buff))
        except Exception as error:  # noqa: BLE001 - zenoh's, or the node's: the caller must get an answer
            count.errors += 1
            text = _error_text(error)
            count.last_error = one_line(text)
            with suppress(Exception):  # errors from zenoh, if the session has been closed
                query.reply_err(text.encode())
        finally:
            query.drop()  # otherwise the caller waits for more replies

    def close(self) -> None:
        """Stop providing services, and end the threads."""
        self._workers.close(_CLOSE_TIME)
        if self._node.ok():
            for _, server in self._provided.values():
                server.shutdown()
        self._provided = {}


def _error_text(error: Exception) -> str:
    """Return the text for a caller elsewhere: the service's own error message, if there is one."""
    if isinstance(error, ServiceError) and error.answer is not None:
        return error.answer.decode("utf-8", "replace")
    return one_line(error)
