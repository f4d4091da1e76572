"""Services and service proxies (https://wiki.ros.org/rospy/Overview/Services)."""

from __future__ import annotations

import logging
import sys
import threading
import time
from collections.abc import Callable, Mapping
from types import TracebackType
from typing import TYPE_CHECKING, Any

import pyros1
from pyros1.drop_in.module_attributes import class_getattr
from pyros1.drop_in.module_attributes import module_hooks as _module_hooks
from pyros1.drop_in.process import PROCESS
from pyros1.ground.errors import (
    ConnectionRefusedByPeerError,
    DeserializationError,
    Error,
    MasterError,
    NodeError,
    NodeShutdownError,
    SerializationError,
    ServiceError,
    ServiceUnavailableError,
    WaitTimeoutError,
)
from pyros1.net.signal_safe import Event
from rospy.core import logerr, logfatal, logwarn
from rospy.exceptions import ROSException, ROSInterruptException, ROSSerializationException
from rospy.impl.encoding_errors import stock_error_for
from rospy.impl.request_transport import RequestTransport, write_error
from rospy.impl.tcpros_base import DEFAULT_BUFF_SIZE
from rospy.msg import args_kwds_to_message
from rospy.msproxy import MasterProxy
from rospy.names import isstring, normalize_name_argument, resolve_name
from rospy.service import SERVICES, ServiceException, _Service

if TYPE_CHECKING:
    from pyros1.node.services.client import ServiceClient

logger = logging.getLogger("rospy.service")


def convert_return_to_response(response: Any, response_class: type[Any]) -> Any:
    """Convert a handler's return value to a response.

    Args:
        response: a response; a list, tuple or dict of its fields; or the value of its only field.
        response_class: class of the response.

    Raises:
        ServiceException: the value cannot be converted.
    """
    if isinstance(response, response_class) or getattr(response, "_type", None) == response_class._type:
        return response
    if response is None:
        raise ServiceException("service handler returned None")
    if isinstance(response, dict):
        try:
            return response_class(**response)
        except AttributeError as error:
            raise ServiceException(f"handler returned invalid value: {error}") from error
    values = response if isinstance(response, (list, tuple)) else [response]
    try:
        return response_class(*values)
    except Exception as error:
        problem = "wrong number of values" if values is response else "invalid value"
        raise ServiceException(f"handler returned {problem}: {error}") from error


class ServiceImpl(_Service):
    """A service that the node provides.

    Args:
        name: name of the service.
        service_class: class of the service.
        handler: called with the request; returns a response, or the values of its fields as a list, tuple or dict, or
            the value of its only field.
        buff_size: accepted for compatibility.
        error_handler: called with (exception, type, value, traceback) when the handler raises an exception; None to log
            it.

    Raises:
        ServiceException: the program already has a service with that name.
        ValueError: the name is not a non-empty string.
    """

    def __init__(
        self,
        name: str,
        service_class: Any,
        handler: Callable[[Any], Any],
        buff_size: int = DEFAULT_BUFF_SIZE,
        error_handler: Callable[..., object] | None = None,
    ) -> None:
        if not name or not isinstance(name, str):
            raise ValueError("service name is not a non-empty string")
        super().__init__(name, service_class)
        self.handler = handler
        self.buff_size = buff_size
        self.uri: str | None = None
        self.registered = False
        self.seq = 0
        self.done = False
        if error_handler is not None:
            self.error_handler = error_handler  # type: ignore[method-assign, assignment]  # programs may do the same
        self._server: Any = None
        self._ended = Event()
        SERVICES.register(self.resolved_name, self)
        PROCESS.add_start_callback(self._start)

    __getattr__ = class_getattr("Service", "pyros1's nodes serve connections themselves", frozenset(["protocol"]))

    def error_handler(
        self, e: BaseException, exc_type: type[BaseException], exc_value: BaseException, tb: TracebackType
    ) -> None:
        """Log an exception that the handler raised."""
        import traceback

        logerr("Error processing request: %s\n%s", e, "".join(traceback.format_exception(exc_type, exc_value, tb)))

    def _start(self, node: pyros1.Node) -> None:
        if self.done or not node.ok():
            return
        try:
            server = self._server = node.advertise_service(self._unresolved_name, self.service_class, self._respond)
        except NodeShutdownError:
            return
        except NodeError as error:
            SERVICES.unregister(self.resolved_name, self)
            raise ServiceException(str(error)) from error
        except MasterError as error:
            logfatal("unable to register service [%s] with the master: %s", self.resolved_name, error)
            return
        self.uri = server.uri
        self.registered = True
        if self.done:  # another thread has ended the service in the meantime
            server.shutdown()

    def _respond(self, request: Any) -> Any:
        transport = RequestTransport(self.resolved_name, request)
        self._handle_request(transport, request)
        return transport.get_response(self.response_class)

    def _handle_request(self, transport: Any, request: Any) -> None:
        """Call the handler, and write its response. Programs replace this to see or change requests and responses.

        Args:
            transport: receives the response: ``send_message(response, seq)`` or ``write_data(bytes)``.
            request: the request.
        """
        try:
            response = convert_return_to_response(self.handler(request), self.response_class)
            self.seq += 1
            transport.send_message(response, self.seq)
        except ServiceException as error:
            self._write_service_error(transport, f"service cannot process request: {error}")
        except Exception as error:  # noqa: BLE001 - the program's code: the error is sent to the client
            error_type, value, trace = sys.exc_info()
            self.error_handler(error, error_type, value, trace)  # type: ignore[arg-type]  # not None: see "except"
            self._write_service_error(transport, f"error processing request: {error}")

    def _write_service_error(self, transport: Any, err_msg: str) -> None:
        """Respond that the call has failed."""
        write_error(transport, err_msg)

    def spin(self) -> None:
        """Wait until the service or the node ends."""
        try:
            while not PROCESS.is_shutdown and not self.done:
                self._ended.wait(0.2)
        except KeyboardInterrupt:
            PROCESS.shutdown("keyboard interrupt")

    def shutdown(self, reason: str = "") -> None:
        """End the service.

        Args:
            reason: accepted for compatibility.
        """
        if self.done:
            return
        self.done = True
        PROCESS.remove_start_callback(self._start)
        SERVICES.unregister(self.resolved_name, self)
        if self._server is not None:
            self._server.shutdown()
        self._ended.set()

    def handle(self, transport: Any, header: Mapping[str, str]) -> None:
        """Raise NotImplementedError: pyros1's node serves connections itself.

        Raises:
            NotImplementedError: always.
        """
        raise NotImplementedError("pyros1's node serves the connections of services itself")


class Service(ServiceImpl):
    """A service that the node provides; see `ServiceImpl`."""


class _NodeStandIn:
    """Takes the place of the node if a program calls services without a node."""

    def __init__(self) -> None:
        self.name = "/unnamed"
        self.host = ""
        self.local_key = ""
        self.stopping = threading.Event()
        self.callback_queue = None
        self.services: dict[str, Any] = {}
        self.log = self

    def warn(self, text: str, *args: object) -> None:
        """Log a warning."""
        logwarn(text, *args)

    def peer_event(self, level: int, text: str, *args: object, **limits: object) -> None:
        """Log a warning about another process."""
        logwarn(text, *args)

    def check_running(self) -> None:
        """Do nothing: it is always running."""

    def pause(self, seconds: float) -> None:
        """Wait."""
        time.sleep(seconds)


class ServiceProxy(_Service):
    """Calls a service.

    Args:
        name: name of the service.
        service_class: class of the service.
        persistent: whether to keep the connection between calls.
        headers: additional fields of the connection header.

    Attributes:
        seq: number of calls.
    """

    __getattr__ = class_getattr(
        "ServiceProxy", "pyros1's nodes manage the connections; see close()", frozenset(["transport", "protocol"])
    )

    def __init__(
        self, name: str, service_class: Any, persistent: bool = False, headers: dict[str, str] | None = None
    ) -> None:
        super().__init__(name, service_class)
        self.persistent = persistent
        self._headers = {str(key): str(value) for key, value in (headers or {}).items()}
        self._client: ServiceClient | None = None
        self.seq = 0

    def _get_service_uri(self, request: Any) -> str:
        """Return the service's URI.

        Raises:
            ServiceException: no node provides the service, or the master cannot be reached.
        """
        try:
            code, _, uri = MasterProxy(None).lookupService(self.resolved_name)
        except OSError as error:
            raise ServiceException("unable to contact master") from error
        if code != 1:
            raise ServiceException(f"service [{self.resolved_name}] unavailable")
        return str(uri)

    @property
    def uri(self) -> str | None:
        """The service's URI according to the master; None before the first call."""
        return self._get_service_uri(None) if self.seq else None

    def wait_for_service(self, timeout: Any = None) -> None:
        """Wait until the service is provided; see `wait_for_service`."""
        wait_for_service(self.resolved_name, timeout)

    def __call__(self, *args: Any, **kwds: Any) -> Any:
        """Call the service; see `call`."""
        return self.call(*args, **kwds)

    def call(self, *args: Any, **kwds: Any) -> Any:
        """Call the service and return its response.

        Args:
            args: the request, or the values of all its fields.
            kwds: the values of some fields by name.

        Raises:
            ServiceException: nobody provides the service, or its handler failed.
            ROSInterruptException: the node is shutting down.
            TypeError: the request is of another type; or positional and named values are mixed.
        """
        request = args_kwds_to_message(self.request_class, args, kwds)
        if PROCESS.is_shutdown:
            raise ServiceException(f"service [{self.resolved_name}] unavailable")
        try:
            client = self._get_client()
            self.seq += 1
            return client.call(request)
        except NodeShutdownError:
            raise ROSInterruptException("node shutdown interrupted service call") from None
        except SerializationError as error:
            stock_error = stock_error_for(error)
            raise (error if isinstance(stock_error, ROSSerializationException) else stock_error) from error.__cause__
        except Error as error:
            raise ServiceException(_failure_text(self.resolved_name, error)) from error

    def _get_client(self) -> ServiceClient:
        client, node = self._client, PROCESS.node
        if client is not None:
            return client
        if node is None:  # rospy can call services without a node
            from pyros1.node.services.client import ServiceClient

            stand_in: Any = _NodeStandIn()
            master = MasterProxy(None).client
            client = ServiceClient(
                stand_in, master, self.resolved_name, self.service_class, self.persistent, self._headers
            )
        else:
            client = self._client = node.service(
                self._unresolved_name, self.service_class, persistent=self.persistent, headers=self._headers
            )
        return client

    def close(self) -> None:
        """Close the connection of a persistent proxy."""
        if self._client is not None:
            self._client.close()


def _failure_text(service: str, error: Error) -> str:
    """Return stock's error message for a call that failed."""
    if isinstance(error, ServiceError) and error.answer is not None:
        return f"service [{service}] responded with an error: {error.answer!r}"
    if isinstance(error, ServiceUnavailableError) and "no node provides it" in str(error):
        return f"service [{service}] unavailable"
    if isinstance(error, (ServiceUnavailableError, ConnectionRefusedByPeerError)):
        return f"unable to connect to service: {error}"
    if isinstance(error, DeserializationError):
        error = Error(f"receive_once[{service}]: DeserializationError {error}")
    return f"transport error completing service call: {error}"


def wait_for_service(service: str, timeout: Any = None) -> None:
    """Wait until a service is provided.

    Args:
        service: name of the service.
        timeout: seconds or a Duration; None for no limit.

    Raises:
        ROSException: the service was not provided in time.
        ROSInterruptException: the node is shutting down.
        ValueError: the timeout is 0.
    """
    seconds = float(timeout.to_sec()) if hasattr(timeout, "to_sec") else timeout
    if seconds == 0:
        raise ValueError("timeout must be non-zero")
    if PROCESS.is_shutdown:
        raise ROSInterruptException("rospy shutdown")
    service = normalize_name_argument(service) or "/"
    name = resolve_name(service)
    if seconds is not None and not seconds > 0:  # the caller's deadline has already passed
        raise ROSException(f"timeout exceeded while waiting for service {name}")
    limit = None if seconds == float("inf") else seconds
    try:
        if PROCESS.node is not None:
            PROCESS.node.wait_for_service(service, limit)
        else:
            from pyros1.node.services.client import wait_for_service as wait

            stand_in: Any = _NodeStandIn()
            wait(stand_in, MasterProxy(None).client, name, limit)
    except WaitTimeoutError:
        raise ROSException(f"timeout exceeded while waiting for service {name}") from None
    except NodeShutdownError:
        raise ROSInterruptException("rospy shutdown") from None


__getattr__, __dir__ = _module_hooks(
    __name__,
    dict.fromkeys(("TCPROSServiceClient", "TCPROSTransport", "TCPROSTransportProtocol"), "rospy.impl.tcpros_base"),
    dict.fromkeys(("TCPService", "service_connection_handler"), "pyros1's nodes serve connections themselves"),
)
