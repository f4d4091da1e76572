"""Common parts of services and service proxies (https://wiki.ros.org/rospy/Overview/Services)."""

from __future__ import annotations

import logging
import threading
from typing import Any

from pyros1.drop_in.module_attributes import module_hooks as _module_hooks
from pyros1.ground.names import canonicalize_name
from rospy.core import *  # noqa: F403  stock's module has these names as well
from rospy.impl.registration import Registration
from rospy.names import LAZY_IMPORTS, normalize_name_argument, resolve_name, warn_if_illegal_name

logger = logging.getLogger("rospy.service")


class ServiceException(Exception):
    """A service call failed."""


class _Service:
    """Base class of Service and ServiceProxy.

    Attributes:
        resolved_name: the full name.
        service_class: the service class.
        request_class, response_class: the classes of its messages.

    Raises:
        AttributeError: the class is not a service class.
    """

    def __init__(self, name: str, service_class: Any) -> None:
        self._unresolved_name = canonicalize_name(normalize_name_argument(name)) or "/"
        if name:
            warn_if_illegal_name(self._unresolved_name, 4)
        self.resolved_name = resolve_name(name)
        self.service_class = service_class
        self.request_class = service_class._request_class
        self.response_class = service_class._response_class


class ServiceManager:
    """A list of the program's services."""

    def __init__(self, registration_listeners: None = None) -> None:
        self.map: dict[str, Any] = {}
        self.lock = threading.RLock()

    def get_services(self) -> list[tuple[str, str | None]]:
        """Return (name, address) of each service."""
        return [(name, service.uri) for name, service in list(self.map.items())]

    def get_service(self, resolved_service_name: str) -> Any:
        """Return a service; None if there is none."""
        return self.map.get(resolved_service_name)

    def register(self, resolved_service_name: str, service: Any) -> None:
        """Add a service.

        Raises:
            ServiceException: there is already a service with that name.
        """
        with self.lock:
            if resolved_service_name in self.map:
                raise ServiceException(f"service [{resolved_service_name}] already registered")
            self.map[resolved_service_name] = service

    def unregister(self, resolved_service_name: str, service: Any) -> None:
        """Remove a service if it exists."""
        with self.lock:
            if self.map.get(resolved_service_name) is service:
                del self.map[resolved_service_name]

    def unregister_all(self) -> None:
        """Shut down all services."""
        for service in list(self.map.values()):
            service.shutdown("unregister_all")


SERVICES = ServiceManager()
"""The services of this program."""

_lazy_imports = {**LAZY_IMPORTS, "Service": "rospy.impl.tcpros_service", "ServiceProxy": "rospy.impl.tcpros_service"}
_lazy_imports |= dict.fromkeys(("BIDIRECTIONAL", "INBOUND", "OUTBOUND", "Transport"), "rospy.impl.transport")
_lazy_imports |= {"wait_for_service": "rospy.impl.tcpros_service", "Log": "rosgraph_msgs.msg"}
__getattr__, __dir__ = _module_hooks(__name__, _lazy_imports)
