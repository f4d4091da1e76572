"""Calls of services for a client."""

from __future__ import annotations

import threading
from typing import Any

from pyros1.graph import probe_service
from pyros1.ground.errors import Error, ServiceError
from pyros1.msgs import load_service
from pyros1.web.robot import Robot
from pyros1.web.rosbridge import frames, rosapi
from pyros1.web.rosbridge.operations import BridgeError, CallService, Id
from pyros1.web.rosbridge.outbox import Frame
from pyros1.web.rosbridge.values import for_cbor, for_json, from_args

_PROBE = 2.0
_MOST_TYPES = 1000


class Calling:
    """The calls of one client.

    Args:
        robot: whose services are called.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._lock = threading.Lock()
        self._under_way: set[Any] = set()
        self._types: dict[tuple[str, str], str] = {}
        self._closed = False

    def answer(self, id: Id, call: CallService) -> list[Frame]:
        """Call a service and return the frames of the answer, whatever happens. It may take long."""
        try:
            values, result = self._values(call), True
        except Error as error:
            values, result = str(error), False
        answer = frames.response(call.service, id, values, result)
        try:
            if call.compression.startswith("cbor"):
                return [frames.binary(answer)]
            return [*frames.packed(frames.text(answer), call.compression, call.fragment_size, f"{id}:parts")]
        except BridgeError as error:
            return [frames.text(frames.response(call.service, id, str(error), False))]

    def close(self) -> None:
        """End all calls."""
        with self._lock:
            self._closed = True
            under_way = list(self._under_way)
        for client in under_way:
            client.close()

    def _values(self, call: CallService) -> Any:
        name = self._robot.node.resolve(call.service)
        if rosapi.has(name):
            return rosapi.run(self._robot, name, call.args)
        if self._robot.access.read_only:
            raise BridgeError("this server is read-only (--read-only)")
        self._robot.check_visible(name)
        key = (name, self._uri(name))
        try:
            response = self._exchange(name, self._type(*key), call)
        except ServiceError:
            self._types.pop(key, None)  # perhaps another node is there now
            raise
        return (for_cbor if call.compression.startswith("cbor") else for_json)(response)

    def _exchange(self, name: str, kind: str, call: CallService) -> Any:
        node = self._robot.node
        cls = load_service(kind)
        request = from_args(cls._request_class, call.args, node.now())
        with node.service(name, cls) as client:
            with self._lock:
                if self._closed:
                    raise BridgeError("the client has gone")
                self._under_way.add(client)
            try:
                return client.call(request, call.timeout)
            finally:
                with self._lock:
                    self._under_way.discard(client)

    def _uri(self, name: str) -> str:
        uri = self._robot.graph.service_uri(name)
        if uri is None:
            raise BridgeError(f"Service {name} does not exist")
        return uri

    def _type(self, name: str, uri: str) -> str:
        kind = self._types.get((name, uri))
        if kind is None:
            kind = probe_service(name, uri, self._robot.node.name, _PROBE).get("type", "")
            if not kind:
                raise BridgeError(f"the provider of {name} does not tell its type")
            if len(self._types) >= _MOST_TYPES:
                self._types.clear()
            self._types[name, uri] = kind
        return kind
