"""Server: lets others change parameters of this node."""

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
    """The service of a server, with what programs use of a `rospy.Service`.

    Args:
        service: pyros1's.

    Attributes:
        resolved_name: full name. service_class, request_class, response_class: of dynamic_reconfigure/Reconfigure.
        uri: its address.
    """

    def __init__(self, service: Any) -> None:
        self._service = service
        self.resolved_name: str = service.name
        self.uri: str = service.uri
        self.service_class = ReconfigureSrv
        self.request_class = ReconfigureSrv._request_class
        self.response_class = ReconfigureSrv._response_class

    def shutdown(self, reason: str = "") -> None:
        """End the service, and wake who waits for it.

        Args:
            reason: for the log.
        """
        self._service.shutdown(reason)

    def spin(self) -> None:
        """Wait until the node ends."""
        rospy.spin()


class Server:
    """Offers parameters to tools and other nodes.

    Args:
        type: the module that a ``.cfg`` file has become, such as ``my_package.cfg.TutorialsConfig``.
        callback: called at first and with each change, as ``callback(config, level)``; returns the configuration.
        namespace: of the parameters, topics and service: within the node's private one, unless it begins with ``/``.

    Attributes:
        config: the current configuration. description: the description as a message.

    Raises:
        DynamicReconfigureCallbackException: the callback has not returned a configuration.
        ROSInitException: there is no node yet.
        ServiceException: the node has a server in this namespace already.
    """

    def __init__(self, type: Any, callback: Callable[[Any, int], Any], namespace: str = "") -> None:
        if PROCESS.node is None:
            raise ROSInitException("client code must call rospy.init_node() first")
        self.mutex = threading.Lock()
        self.type = type
        self.callback = callback
        try:
            self._server = pyros1.reconfigure.Server(
                PROCESS.node, type, self._changed, namespace, make=Config, remap=False
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

    def _changed(self, config: Any, level: int) -> Any:
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
