"""The master's API, with exceptions for failed calls (https://wiki.ros.org/ROS/Master_API)."""

from __future__ import annotations

import errno
from typing import Any

from pyros1.drop_in.binary import bytes_to_binary
from pyros1.drop_in.module_attributes import module_getattr
from pyros1.ground.errors import MasterError as _ClientMasterError
from pyros1.ground.errors import MasterUnreachableError, SerializationError, TransportError
from pyros1.net.master_client import MasterClient
from rosgraph.names import make_caller_id
from rosgraph.network import parse_http_host_and_port
from rosgraph.rosenv import get_master_uri

__getattr__ = module_getattr(__name__)


class MasterException(Exception):
    """Base class of the exceptions that `Master` raises."""


class MasterFailure(MasterException):
    """A call failed (code 0)."""


class MasterError(MasterException):
    """A call had invalid arguments (code -1)."""


ROSMasterException, Failure, Error = MasterException, MasterFailure, MasterError


class Master:
    """Calls the master under a caller's name.

    Args:
        caller_id: name of the caller.
        master_uri: address of the master; None for the address in the environment.

    Raises:
        ValueError: the address is invalid.
        MasterFailure, MasterError: the master rejects the call (raised by all methods).
        OSError: the master does not respond (raised by all methods).
        TypeError, OverflowError: XML-RPC cannot send an argument (raised by all methods).
    """

    def __init__(self, caller_id: str, master_uri: str | None = None) -> None:
        self.caller_id = make_caller_id(caller_id).rstrip("/")
        self.master_uri = master_uri or get_master_uri()
        try:
            parse_http_host_and_port(self.master_uri)
        except ValueError:
            raise ValueError(f"invalid master URI: {self.master_uri}") from None
        self._client = MasterClient(self.caller_id, self.master_uri)

    def _call(self, method: str, *args: Any) -> Any:
        try:
            return self._client.call(method, *args)
        except SerializationError as error:  # XML-RPC cannot represent an argument
            raise (OverflowError if "does not fit" in str(error) else TypeError)(str(error)) from None
        except (MasterUnreachableError, TransportError) as error:
            raise _os_error(error) from None
        except _ClientMasterError as error:
            raise (MasterFailure if getattr(error, "code", -1) == 0 else MasterError)(str(error)) from None

    def is_online(self) -> bool:
        """Return whether the master responds."""
        try:
            self.getPid()
        except (MasterException, OSError):
            return False
        return True

    def getUri(self) -> str:
        """Return the master's address."""
        return self._call("getUri")

    def getPid(self) -> int:
        """Return the master's process ID."""
        return self._call("getPid")

    def getSystemState(self) -> list[Any]:
        """Return publishers, subscribers and services."""
        return self._call("getSystemState")

    def getPublishedTopics(self, subgraph: str) -> list[list[str]]:
        """Return the published topics in a namespace, with their types."""
        return self._call("getPublishedTopics", subgraph)

    def getTopicTypes(self) -> list[list[str]]:
        """Return all topics and their types."""
        return self._call("getTopicTypes")

    def lookupNode(self, node_name: str) -> str:
        """Return the address of a node's API."""
        return self._call("lookupNode", node_name)

    def lookupService(self, service: str) -> str:
        """Return the address of a service."""
        return self._call("lookupService", service)

    def getParam(self, key: str) -> Any:
        """Return a parameter."""
        return bytes_to_binary(self._call("getParam", key))

    def setParam(self, key: str, value: Any) -> Any:
        """Set a parameter."""
        return self._call("setParam", key, value)

    def hasParam(self, key: str) -> bool:
        """Return whether a parameter is set."""
        return self._call("hasParam", key)

    def deleteParam(self, key: str) -> Any:
        """Delete a parameter."""
        return self._call("deleteParam", key)

    def searchParam(self, key: str) -> str:
        """Return the full name of the nearest parameter with that name."""
        return self._call("searchParam", key)

    def getParamNames(self) -> list[str]:
        """Return the names of all parameters."""
        return self._call("getParamNames")

    def subscribeParam(self, caller_api: str, key: str) -> Any:
        """Subscribe to changes of a parameter."""
        return self._call("subscribeParam", caller_api, key)

    def unsubscribeParam(self, caller_api: str, key: str) -> Any:
        """Unsubscribe from changes of a parameter."""
        return self._call("unsubscribeParam", caller_api, key)

    def registerService(self, service: str, service_api: str, caller_api: str) -> Any:
        """Register a service."""
        return self._call("registerService", service, service_api, caller_api)

    def unregisterService(self, service: str, service_api: str) -> Any:
        """Unregister a service."""
        return self._call("unregisterService", service, service_api)

    def registerSubscriber(self, topic: str, topic_type: str, caller_api: str) -> list[str]:
        """Register a subscriber; return the addresses of the publishers."""
        return self._call("registerSubscriber", topic, topic_type, caller_api)

    def unregisterSubscriber(self, topic: str, caller_api: str) -> Any:
        """Unregister a subscriber."""
        return self._call("unregisterSubscriber", topic, caller_api)

    def registerPublisher(self, topic: str, topic_type: str, caller_api: str) -> list[str]:
        """Register a publisher; return the addresses of the subscribers."""
        return self._call("registerPublisher", topic, topic_type, caller_api)

    def unregisterPublisher(self, topic: str, caller_api: str) -> Any:
        """Unregister a publisher."""
        return self._call("unregisterPublisher", topic, caller_api)


def _os_error(error: Exception) -> OSError:
    """Return the error that stock raises if the master does not respond: the system's error, with pyros1's message."""
    cause: BaseException | None = error
    while cause is not None and (not isinstance(cause, OSError) or cause.errno is None):
        cause = cause.__cause__ or cause.__context__
    if cause is not None:
        return type(cause)(cause.errno, str(error))
    if isinstance(error, TimeoutError):
        return TimeoutError(str(error))
    return ConnectionRefusedError(errno.ECONNREFUSED, str(error))


def is_online(master_uri: str | None = None) -> bool:
    """Return whether a master responds."""
    return Master("rosgraph", master_uri).is_online()
