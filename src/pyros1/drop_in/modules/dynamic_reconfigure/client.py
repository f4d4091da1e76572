"""Client: reads and changes parameters of other nodes."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from typing import Any

import rospy
from rospy.exceptions import ROSException, ROSInitException, ROSInterruptException
from rospy.service import ServiceException

import pyros1.reconfigure
from dynamic_reconfigure import DynamicReconfigureCallbackException, DynamicReconfigureParameterException
from dynamic_reconfigure.encoding import Config, decode_config, decode_description, encode_config, extract_params
from pyros1.drop_in.process import PROCESS
from pyros1.ground.errors import NodeShutdownError, ServiceError, WaitTimeoutError
from pyros1.msgs.dynamic_reconfigure.msg import Config as ConfigMsg
from pyros1.msgs.dynamic_reconfigure.msg import ConfigDescription as ConfigDescrMsg
from pyros1.msgs.dynamic_reconfigure.srv import Reconfigure as ReconfigureSrv
from pyros1.reconfigure.encoding import groups_of

_Callback = Callable[[Any], object]


class Client:
    """Access to the parameters of another node.

    Args:
        name: the other node's name, or the namespace of its parameters.
        timeout: seconds to wait for the other node; None for no limit.
        config_callback: called with each new configuration.
        description_callback: called with the list of parameters.

    Raises:
        ROSException: the other node does not respond in time.
    """

    def __init__(
        self,
        name: str,
        timeout: float | None = None,
        config_callback: _Callback | None = None,
        description_callback: _Callback | None = None,
    ) -> None:
        if PROCESS.node is None:
            raise ROSInitException("client code must call rospy.init_node() first")
        self.name = name
        try:
            self._client = pyros1.reconfigure.Client(
                PROCESS.node, name, timeout, config_callback, description_callback, make=Config, remap=False
            )
        except WaitTimeoutError as error:
            raise ROSException(str(error)) from None
        except NodeShutdownError:
            raise ROSInterruptException("rospy shutdown") from None

    def _wait_or_none(self, wait: Callable[[float | None], Any], timeout: float | None) -> Any:
        """Call ``wait``, which waits for a message; return None if none arrives in time or this node shuts down."""
        try:
            return wait(timeout)
        except (WaitTimeoutError, NodeShutdownError):
            return None

    def get_configuration(self, timeout: float | None = None) -> Any:
        """Return the latest configuration; None if none arrives in time.

        Args:
            timeout: seconds to wait for the first configuration; None or 0 for no limit.
        """
        return self._wait_or_none(self._client.config, timeout or None)

    def get_parameter_descriptions(self, timeout: float | None = None) -> Any:
        """Return all parameters as dictionaries, or None; see `get_configuration`."""
        return self._wait_or_none(self._client.description, timeout or None)

    def get_group_descriptions(self, timeout: float | None = None) -> Any:
        """Return the tree of groups, or None; see `get_configuration`."""
        return self._wait_or_none(self._client.groups, timeout or None)

    def update_configuration(self, changes: dict[str, Any]) -> Any:
        """Change parameters; return the new configuration, or None if this node shuts down.

        Raises:
            DynamicReconfigureParameterException: a parameter does not exist, or the value is not valid for it.
            DynamicReconfigureCallbackException: the other node refuses the change, or has exited.
        """
        try:
            return self._client.update(changes)
        except pyros1.reconfigure.ParameterError as error:
            raise DynamicReconfigureParameterException(str(error)) from None
        except ServiceError as error:
            raise DynamicReconfigureCallbackException("service call failed") from error
        except NodeShutdownError:
            return None

    def update_groups(self, changes: dict[str, bool]) -> Any:
        """Set the states of groups in this client's description, and return the description.

        As in stock ROS, nothing is sent: use ``update_configuration({"groups": changes})`` to switch groups on and off.

        Args:
            changes: name of a group, other than the top one -> whether it is on.
        """
        description = self.get_group_descriptions()
        for group in groups_of(description):
            if group is not description and group["name"] in changes:
                group["state"] = changes[group["name"]]
        return description

    def close(self) -> None:
        """Stop receiving configurations and descriptions."""
        self._client.close()

    def get_config_callback(self) -> _Callback | None:
        """Return the function that is called with each new configuration."""
        return self._client.on_config

    def set_config_callback(self, value: _Callback | None) -> None:
        """Call a function with each new configuration, and now with the latest one."""
        self._client.on_config = value
        config = self._wait_or_none(self._client.config, 0)
        if value is not None and config is not None:
            value(config)

    config_callback = property(get_config_callback, set_config_callback)

    def get_description_callback(self) -> _Callback | None:
        """Return the function that is called with the list of parameters."""
        return self._client.on_description

    def set_description_callback(self, value: _Callback | None) -> None:
        """Call a function with the list of parameters: now if the list is known, and whenever it arrives."""
        self._client.on_description = value
        parameters = self._wait_or_none(self._client.description, 0)
        if value is not None and parameters is not None:
            value(parameters)

    description_callback = property(get_description_callback, set_description_callback)

    @property
    def config(self) -> Any:
        """The latest configuration; None until the first one arrives."""
        return self._wait_or_none(self._client.config, 0)

    @property
    def param_description(self) -> Any:
        """All parameters; None until the description arrives."""
        return self._wait_or_none(self._client.description, 0)

    @property
    def group_description(self) -> Any:
        """The groups; None until the description arrives."""
        return self._wait_or_none(self._client.groups, 0)
