"""Server: lets other nodes change parameters of this node."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import rospy
from rospy.exceptions import ROSInitException
from rospy.service import ServiceException

import pyros1.reconfigure
from dynamic_reconfigure import DynamicReconfigureCallbackException
from dynamic_reconfigure.encoding import (
    Config,
    decode_config,
    encode_config,
    encode_description,
    extract_params,
    get_tree,
    initial_config,
)
from pyros1.drop_in.process import PROCESS
from pyros1.ground.errors import NodeError
from pyros1.msgs.dynamic_reconfigure.msg import Config as ConfigMsg
from pyros1.msgs.dynamic_reconfigure.msg import ConfigDescription as ConfigDescrMsg
from pyros1.msgs.dynamic_reconfigure.srv import Reconfigure as ReconfigureSrv


class SetService:
    """A server's service, with the members of `rospy.Service` that programs use.

    Args:
        service: pyros1's service.

    Attributes:
        resolved_name: full name.
        service_class, request_class, response_class: the classes of dynamic_reconfigure/Reconfigure.
        uri: the service's URI.
    """

    def __init__(self, service: Any) -> None:
        self._service = service
        self.resolved_name: str = service.name
        self.uri: str = service.uri
        self.service_class = ReconfigureSrv
        self.request_class = ReconfigureSrv._request_class
        self.response_class = ReconfigureSrv._response_class

    def shutdown(self, reason: str = "") -> None:
        """Shut down the service, and wake threads that wait for its shutdown.

        Args:
            reason: the reason to log.
        """
        self._service.shutdown(reason)

    def spin(self) -> None:
        """Wait until the node shuts down."""
        rospy.spin()


class Server:
    """Offers parameters to tools and other nodes.

    Args:
        type: the module created from a ``.cfg`` file, such as ``my_package.cfg.TutorialsConfig``.
        callback: called as ``callback(config, level)`` initially and for each change; returns the configuration.
        namespace: namespace of parameters, topics and service, below the private namespace unless it starts with
            ``/``.

    Attributes:
        config: the current configuration.
        description: the description as a message.

    Raises:
        DynamicReconfigureCallbackException: the callback has not returned a configuration.
        ROSInitException: the node has not been started.
        ServiceException: the node already has a server in this namespace.
    """

    def __init__(self, type: Any, callback: Callable[[Any, int], Any], namespace: str = "") -> None:
        if PROCESS.node is None:
            raise ROSInitException("client code must call rospy.init_node() first")
        self.mutex = threading.Lock()
        self.type = type
        self.callback = callback
        try:
            self._server = pyros1.reconfigure.Server(
                PROCESS.node, type, self._on_change, namespace, make=Config, remap=False
            )
        except pyros1.reconfigure.CallbackError as error:
            raise DynamicReconfigureCallbackException(str(error)) from None
        except NodeError as error:
            raise ServiceException(str(error)) from None
        self.ns = self._server.namespace
        self.description = self._server.message
        self.descr_topic = self._server.descriptions
        self.update_topic = self._server.updates
        self.set_service = SetService(self._server.service)

    def _on_change(self, config: Any, level: int) -> Any:
        return self.callback(config, level)

    @property
    def config(self) -> Any:
        """The current configuration."""
        return self._server.config

    def update_configuration(self, changes: dict[str, Any]) -> Any:
        """Change parameters from within the node; return the new configuration.

        Raises:
            DynamicReconfigureCallbackException: the callback has not returned a configuration.
        """
        try:
            return self._server.update(changes)
        except pyros1.reconfigure.CallbackError as error:
            raise DynamicReconfigureCallbackException(str(error)) from None
