"""Calls services for clients, including rosapi's."""

from __future__ import annotations

from typing import Any

from pyros1.graph import probe_service
from pyros1.ground.errors import Error, ServiceError
from pyros1.msgs import load_service
from pyros1.web.robot import Robot
from pyros1.web.rosbridge import frames, rosapi
from pyros1.web.rosbridge.operations import BridgeError, CallService, Id
from pyros1.web.rosbridge.values import for_cbor, from_args
from pyros1.web.server.sending import Frame
from pyros1.web.service_calls import ServiceCalls

_PROBE_TIMEOUT = 2.0
MAX_CHARACTERS = 64 << 20
"""Maximum number of characters (of JSON) or bytes (of CBOR) in a response."""
_MAX_CACHED_TYPES = 1000


class ServiceCaller:
    """Calls services for one client.

    Args:
        robot: the robot whose services are called.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._service_calls = ServiceCalls()
        self._types: dict[tuple[str, str], str] = {}

    def call(self, id: Id, call: CallService) -> list[Frame]:
        """Call a service, and return the frames with the response or the error. This may take a long time."""
        try:
            values, result = self._call_service(call), True
        except Error as error:
            values, result = str(error), False
        response = frames.response(call.service, id, values, result)
        try:
            encoded = frames.to_cbor(response) if _uses_cbor(call) else frames.to_json(response)
            if len(encoded) > MAX_CHARACTERS:
                raise BridgeError(f"the response has {len(encoded)} characters; the limit is {MAX_CHARACTERS}")
            if isinstance(encoded, bytes):
                return [encoded]
            return [*frames.split(frames.compress(encoded, call.compression), call.fragment_size, f"{id}:parts")]
        except BridgeError as error:
            return [frames.to_json(frames.response(call.service, id, str(error), False))]

    def close(self) -> None:
        """Cancel all running calls."""
        self._service_calls.close()

    def _call_service(self, call: CallService) -> Any:
        name = self._robot.full_name(call.service)
        if rosapi.is_rosapi_name(name):
            return rosapi.run(self._robot, name, call.args)
        if self._robot.access.read_only:
            raise BridgeError("this server is read-only (--read-only)")
        self._robot.check_service_visible(name)
        key = (name, self._uri(name))
        try:
            response = self._send_request(name, self._find_type(*key), call)
        except ServiceError:
            self._types.pop(key, None)  # perhaps another node provides the service now, with another type
            raise
        return for_cbor(response) if _uses_cbor(call) else response

    def _send_request(self, name: str, type_name: str, call: CallService) -> Any:
        node = self._robot.node
        cls = load_service(type_name)
        request = from_args(cls._request_class, call.args, node.now())
        return self._service_calls.call(node, name, cls, request, call.timeout)

    def _uri(self, name: str) -> str:
        uri = self._robot.graph.service_uri(name)
        if uri is None:
            raise BridgeError(f"Service {name} does not exist")
        return uri

    def _find_type(self, name: str, uri: str) -> str:
        type_name = self._types.get((name, uri))
        if type_name is None:
            type_name = probe_service(name, uri, self._robot.node.name, _PROBE_TIMEOUT).get("type", "")
            if not type_name:
                raise BridgeError(f"the provider of {name} does not report its type")
            if len(self._types) >= _MAX_CACHED_TYPES:
                self._types.clear()
            self._types[name, uri] = type_name
        return type_name


def _uses_cbor(call: CallService) -> bool:
    return call.compression.startswith("cbor")
