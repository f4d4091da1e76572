"""Calls ROS 2 services through rclpy, blocking and non-blocking."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from pyros1.ground.errors import Error, ServiceRefusal
from pyros1.ground.terminal_text import one_line
from pyros1.ros2.rclpy_side.rclpy_modules import RclpyModules

READY_TIME = 5.0
"""Seconds to wait until a service is discovered: before that, DDS drops requests."""
_READY_PERIOD = 0.02


class OutgoingCalls:
    """The calls that a bridge makes. May be used in several threads.

    Args:
        rclpy: encodes and decodes messages.
    """

    def __init__(self, rclpy: RclpyModules) -> None:
        self._rclpy = rclpy
        self._waiting: dict[threading.Event, Any] = {}  # the event that ends the wait -> the client
        self._started: set[_StartedCall] = set()
        self._closing = threading.Event()

    def call(self, client: Any, request_class: Any, request: bytes, timeout: float) -> bytes:
        """Return the encoded response of a service.

        Args:
            client: rclpy's client.
            request_class: the class of its requests.
            request: the encoded request.
            timeout: maximum number of seconds to wait.

        Raises:
            ServiceRefusal: there was no response, or an error.
        """
        done, future = threading.Event(), None
        self._waiting[done] = client
        try:
            deadline = time.monotonic() + timeout
            self._await_service(client, min(timeout, READY_TIME))
            if done.is_set():
                raise ServiceRefusal("the bridge has no connection to ROS 2")
            future = client.call_async(self._rclpy.deserialize(request, request_class))
            future.add_done_callback(lambda _: done.set())
            if self._closing.is_set() or not done.wait(max(0.0, deadline - time.monotonic())) or not future.done():
                raise ServiceRefusal(
                    "the bridge is shutting down" if self._closing.is_set() else "the service in ROS 2 does not respond"
                )
            return bytes(self._rclpy.serialize(future.result()))
        except Error:
            raise
        except Exception as error:
            raise ServiceRefusal(f"the bridge cannot call it: {one_line(error, 200)}") from error
        finally:
            self._waiting.pop(done, None)
            if future is not None:
                client.remove_pending_request(future)

    def start(
        self,
        client: Any,
        request_class: Any,
        request: bytes,
        timeout: float,
        done: Callable[[bytes | ServiceRefusal], object],
    ) -> None:
        """Call a service without waiting; see `pyros1.ros2.zenoh.session.Ros2Session.start_call`.

        Raises:
            ServiceRefusal: the request cannot be sent.
        """
        try:
            message = self._rclpy.deserialize(request, request_class)
        except Exception as error:
            raise ServiceRefusal(f"the bridge cannot call it: {one_line(error, 200)}") from error
        call = _StartedCall(client, message, timeout, done, self._rclpy.serialize)
        self._started.add(call)
        call.poll()
        if self._closing.is_set():
            call.end(ServiceRefusal("the bridge is shutting down"))

    def poll(self) -> None:
        """Send calls whose service has appeared, and end those that have waited too long. Call this periodically."""
        for call in [*self._started]:
            call.poll()
            if call.is_done:
                self._started.discard(call)

    def drop_client(self, client: Any) -> None:
        """End the calls of a destroyed client, whose responses would never arrive."""
        for done, its_client in [*self._waiting.items()]:
            if its_client is client:
                done.set()
        for call in [*self._started]:
            if call.client is client:
                call.end(ServiceRefusal("the bridge has no connection to ROS 2"))

    def _await_service(self, client: Any, timeout: float) -> None:
        deadline = time.monotonic() + timeout
        while not client.service_is_ready():
            if self._closing.wait(_READY_PERIOD) or time.monotonic() >= deadline:
                raise ServiceRefusal("the service in ROS 2 is not there")

    def close(self) -> None:
        """End all calls, and refuse new ones."""
        self._closing.set()
        for done in [*self._waiting]:
            done.set()
        for call in [*self._started]:
            call.end(ServiceRefusal("the bridge is shutting down"))


class _StartedCall:
    """A non-blocking call."""

    def __init__(
        self,
        client: Any,
        message: Any,
        timeout: float,
        done: Callable[[bytes | ServiceRefusal], object],
        serialize: Callable[[Any], Any],
    ) -> None:
        now = time.monotonic()
        self.is_done = False
        self.client = client
        self._message = message
        self._deadline = now + timeout
        self._ready_deadline = now + min(timeout, READY_TIME)
        self._done = done
        self._serialize = serialize
        self._future: Any = None
        self._lock = threading.Lock()

    def poll(self) -> None:
        """Send the request if the service is ready, and end the call if it has timed out."""
        now, is_new = time.monotonic(), False
        try:
            with self._lock:
                if self._future is None and not self.is_done and self.client.service_is_ready():
                    self._future, is_new = self.client.call_async(self._message), True
                    self._message = None
                future = self._future
        except Exception as error:  # noqa: BLE001 - rclpy's own, of any kind
            self.end(ServiceRefusal(f"the bridge cannot call it: {one_line(error, 200)}"))
            return
        if future is None:
            if now >= self._ready_deadline:
                self.end(ServiceRefusal("the service in ROS 2 is not there"))
        elif is_new:
            future.add_done_callback(self._on_response)
        elif now >= self._deadline:
            self.end(ServiceRefusal("the service in ROS 2 does not respond"))

    def _on_response(self, future: Any) -> None:
        try:
            response = bytes(self._serialize(future.result()))
        except Exception as error:  # noqa: BLE001 - rclpy's own, of any kind
            self.end(ServiceRefusal(f"the service in ROS 2 does not respond: {one_line(error, 200)}"))
        else:
            self.end(response)

    def end(self, response: bytes | ServiceRefusal) -> None:
        """Pass on the response, unless one was passed on before."""
        with self._lock:
            if self.is_done:
                return
            self.is_done = True
            future = self._future
        if future is not None:
            with suppress(Exception):  # rclpy's own, if the client has ended
                self.client.remove_pending_request(future)
        self._done(response)
