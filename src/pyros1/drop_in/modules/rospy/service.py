"""Services (https://wiki.ros.org/rospy/Overview/Services)."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import pyros1
from pyros1.drop_in.process import PROCESS
from pyros1.ground.errors import Error, NodeShutdownError, WaitTimeoutError
from rospy.exceptions import ROSException, ROSInterruptException
from rospy.names import resolve_name


class ServiceException(Exception):
    """A service call failed."""


class _Service:
    """Base of Service and ServiceProxy.

    Attributes:
        resolved_name: full name. service_class, request_class, response_class: as given, or in it. type, md5sum: of it.
    """

    def __init__(self, name: str, service_class: Any) -> None:
        self.resolved_name = resolve_name(name)
        self.service_class = service_class
        self.request_class = service_class._request_class
        self.response_class = service_class._response_class
        self.type = service_class._type
        self.md5sum = service_class._md5sum


class Service(_Service):
    """A service that the node provides.

    Args:
        name: of the service.
        service_class: its class.
        handler: called with the request; returns a response, or the values of its fields as a list, tuple or dict, or
            the value of its only field.
        buff_size: as in rospy.
        error_handler: called with (exception, type, value, traceback) when the handler raises.
    """

    def __init__(
        self,
        name: str,
        service_class: Any,
        handler: Callable[[Any], Any],
        buff_size: int = 65536,
        error_handler: Callable[..., object] | None = None,
    ) -> None:
        super().__init__(name, service_class)
        self.handler = handler
        self.error_handler = error_handler
        self._server: Any = None
        self._ended = False
        PROCESS.when_started(self._start)

    def _start(self, node: pyros1.Node) -> None:
        if self._ended:
            return
        try:
            self._server = node.advertise_service(self.resolved_name, self.service_class, self._handle)
        except pyros1.NodeError as error:
            raise ServiceException(str(error)) from error

    def _handle(self, request: Any) -> Any:
        try:
            return self.handler(request)
        except Exception as error:
            if self.error_handler is not None:
                self.error_handler(error, *sys.exc_info())
            raise

    def spin(self) -> None:
        """Wait until the node shuts down."""
        from rospy.client import spin

        spin()

    def shutdown(self, reason: str = "") -> None:
        """End the service."""
        self._ended = True
        PROCESS.forget(self._start)
        if self._server is not None:
            self._server.shutdown(reason)


class ServiceProxy(_Service):
    """A way to call a service.

    Args:
        name: of the service.
        service_class: its class.
        persistent: keep the connection from call to call.
        headers: further fields of the connection header.
    """

    def __init__(
        self, name: str, service_class: Any, persistent: bool = False, headers: dict[str, str] | None = None
    ) -> None:
        super().__init__(name, service_class)
        self.persistent = persistent
        self._headers = headers
        self._client: Any = None

    def wait_for_service(self, timeout: Any = None) -> None:
        """Wait until the service is provided."""
        wait_for_service(self.resolved_name, timeout)

    def __call__(self, *args: Any, **kwds: Any) -> Any:
        """Call the service with a request, or the values of its fields."""
        return self.call(*args, **kwds)

    def call(self, *args: Any, **kwds: Any) -> Any:
        """Call the service.

        Raises:
            ServiceException: the service is not there, or its handler failed.
            ROSInterruptException: the node is shutting down.
        """
        node = PROCESS.node
        if node is None:
            raise ROSException("ROS node has not been initialized yet. Please call init_node() first")
        if self._client is None:
            self._client = node.service(
                self.resolved_name, self.service_class, persistent=self.persistent, headers=self._headers
            )
        try:
            return self._client(*args, **kwds)
        except NodeShutdownError:
            raise ROSInterruptException("node shutdown interrupted service call") from None
        except Error as error:
            raise ServiceException(str(error)) from error

    def close(self) -> None:
        """Close the connection of a persistent proxy."""
        if self._client is not None:
            self._client.close()


def wait_for_service(service: str, timeout: Any = None) -> None:
    """Wait until a service is provided.

    Args:
        timeout: seconds or a Duration; None: no limit.

    Raises:
        ROSException: it was not provided in time.
        ROSInterruptException: the node is shutting down.
        ValueError: the timeout is 0.
    """
    seconds = float(timeout.to_sec()) if hasattr(timeout, "to_sec") else timeout
    if seconds == 0:
        raise ValueError("timeout must be non-zero")
    deadline = None if seconds is None else time.monotonic() + float(seconds)
    while PROCESS.node is None:  # rospy waits without a node, too
        if deadline is not None and time.monotonic() >= deadline:
            raise ROSException(f"timeout exceeded while waiting for service {resolve_name(service)}")
        time.sleep(0.05)
    left = None if deadline is None else max(0.001, deadline - time.monotonic())
    try:
        PROCESS.node.wait_for_service(resolve_name(service), left)
    except WaitTimeoutError:
        raise ROSException(f"timeout exceeded while waiting for service {resolve_name(service)}") from None
    except NodeShutdownError:
        raise ROSInterruptException("rospy shutdown") from None
