"""Services that a client provides. Calls are sent to the client, and threads of the node wait for the responses."""

from __future__ import annotations

import threading
from collections.abc import Callable
from itertools import count

from pyros1.ground.errors import MessageError, ServiceRefusal
from pyros1.msgs import Message, load_service
from pyros1.web.robot import Robot
from pyros1.web.rosbridge import frames
from pyros1.web.rosbridge.operations import MAX_CALL_SECONDS, BridgeError, Id, ServiceResponse
from pyros1.web.rosbridge.outbox import Outbox
from pyros1.web.rosbridge.values import from_args

MAX_SERVICES = 200
MAX_CALLS = 100
"""Maximum number of pending calls to a client's services."""


class ProvidedServices:
    """The services that one client provides.

    Args:
        robot: the robot in whose system the services are provided.
        outbox: the client's outbox.
    """

    def __init__(self, robot: Robot, outbox: Outbox) -> None:
        self._robot = robot
        self._outbox = outbox
        self._unadvertisers: dict[str, Callable[[], None]] = {}  # by the service's name as sent by the client
        self._lock = threading.Lock()
        self._pending_calls: dict[str, _PendingCall] = {}
        self._call_numbers = count(1)
        self._closed = False

    def advertise(self, name: str, type_name: str) -> None:
        """Let the client provide a service, in place of any other client that provides the service.

        Raises:
            BridgeError: the client provides too many services.
            Error: the type does not exist, or the server's own node provides the service.
        """
        full_name = self._robot.full_name(name)
        self._robot.check_service_visible(full_name)
        cls = load_service(type_name)
        if name not in self._unadvertisers and len(self._unadvertisers) >= MAX_SERVICES:
            raise BridgeError(f"a client can provide at most {MAX_SERVICES} services")
        self._unadvertisers[name] = self._robot.client_services.provide(
            full_name, cls, lambda request: self._call_client(name, cls._response_class, request)
        )

    def unadvertise(self, name: str) -> None:
        """Stop providing a service.

        Raises:
            BridgeError: the client does not provide the service.
        """
        unadvertise_service = self._unadvertisers.pop(name, None)
        if unadvertise_service is None:
            raise BridgeError(f"you do not provide {name}")
        unadvertise_service()
        self._cancel_calls(name)

    def pass_response(self, id: Id, response: ServiceResponse) -> None:
        """Pass a response from the client to the call that waits for it.

        Raises:
            BridgeError: no call waits for this response.
        """
        call = self._pending_calls.get(id) if isinstance(id, str) else None
        if call is None or call.service != response.service:
            raise BridgeError(f"no caller is waiting for this response from {response.service}")
        call.response = response
        call.done.set()

    def close(self) -> None:
        """Stop providing all services."""
        with self._lock:
            self._closed = True
        for name in list(self._unadvertisers):
            self.unadvertise(name)

    def _cancel_calls(self, name: str) -> None:
        with self._lock:
            calls = [call for call in self._pending_calls.values() if call.service == name]
        for call in calls:
            call.done.set()

    def _call_client(self, name: str, cls: type[Message], request: Message) -> Message:
        call = _PendingCall(name)
        id = f"service_request:{name}:{next(self._call_numbers)}"
        with self._lock:
            if self._closed or len(self._pending_calls) >= MAX_CALLS or self._outbox.is_overfull():
                raise ServiceRefusal(f"the client that provides {name} is too busy")
            self._pending_calls[id] = call
        try:
            self._outbox.enqueue(frames.call(name, id, request))
            finished = call.done.wait(MAX_CALL_SECONDS)
        finally:
            with self._lock:
                del self._pending_calls[id]
        response = call.response
        if response is None:
            raise ServiceRefusal(
                f"the client that provides {name} has disconnected"
                if finished
                else f"{name}: the client does not respond"
            )
        if not response.result:
            reason = response.values if isinstance(response.values, str) else frames.to_json(response.values)
            raise ServiceRefusal(reason[:1000])
        try:
            message = from_args(cls, response.values, self._robot.node.now())
            cls._encode(message)  # an encoding error that occurs later would not reveal its cause
            return message
        except MessageError as error:
            raise ServiceRefusal(f"the client that provides {name} sent an invalid response: {error}"[:1000]) from None


class _PendingCall:
    def __init__(self, service: str) -> None:
        self.service = service
        self.done = threading.Event()
        self.response: ServiceResponse | None = None
