"""rosservice, by pyros1: lists and calls services (https://wiki.ros.org/rosservice)."""

from __future__ import annotations

import sys
from typing import Any
from urllib.parse import urlparse

import genpy
import rosgraph
import roslib.message
import rospy
from genpy.message import get_printable_message_args
from rosgraph.names import script_resolve_name

from pyros1.drop_in.commands import main as _main
from pyros1.drop_in.commands import run as _run
from pyros1.drop_in.module_attributes import module_getattr
from pyros1.graph import names_in_namespace, probe_service
from pyros1.ground.errors import ServiceUnavailableError

__getattr__ = module_getattr(__name__)

NAME = "rosservice"
_TIMEOUT = 5.0


class ROSServiceException(Exception):
    """A service is unknown or cannot be called."""


class ROSServiceIOException(ROSServiceException):
    """The master, or a service's node, does not respond."""


def _succeed(args: tuple[int, str, Any]) -> Any:
    """Return the value in an API's reply; raise ROSServiceException if the call failed."""
    code, message, value = args
    if code != 1:
        raise ROSServiceException(f"remote call failed: {message}")
    return value


def _get_master() -> Any:
    return rosgraph.Master("/rosservice")


def _services() -> list[Any]:
    try:
        services: list[Any] = _get_master().getSystemState()[2]
    except OSError:
        raise ROSServiceIOException("Unable to communicate with master!") from None
    return services


def get_service_headers(service_name: str, service_uri: str) -> dict[str, str]:
    """Return the connection header of a service's node.

    Raises:
        ROSServiceIOException: the service does not respond.
        ROSServiceException: the address is invalid.
    """
    if urlparse(service_uri).scheme != "rosrpc":
        raise ROSServiceException(f"invalid service URI: {service_uri}")
    try:
        return probe_service(service_name, service_uri, "/rosservice", _TIMEOUT)
    except ServiceUnavailableError as error:
        raise ROSServiceIOException(
            f"Unable to communicate with service [{service_name}], address [{service_uri}]"
        ) from error


def get_service_uri(service_name: str) -> str | None:
    """Return a service's address; None if no node provides it. Raises ROSServiceIOException without a master."""
    try:
        return str(_get_master().lookupService(service_name))
    except rosgraph.MasterException:
        return None
    except OSError:
        raise ROSServiceIOException("Unable to communicate with master!") from None


def get_service_type(service_name: str) -> str | None:
    """Return the type of a service; None if it is unknown.

    Raises:
        ROSServiceIOException: the master or the service's node does not respond.
    """
    uri = get_service_uri(service_name) if service_name.startswith("/") else None
    return get_service_headers(service_name, uri).get("type") if uri else None


def get_service_node(service_name: str) -> str | None:
    """Return the node that provides a service; None if there is none."""
    for name, nodes in _services():
        if name == service_name and nodes:
            return str(nodes[0])
    return None


def get_service_list(node: str | None = None, namespace: str | None = None, include_nodes: bool = False) -> list[Any]:
    """Return the names of services.

    Args:
        node: the node whose services to return; None for all nodes.
        namespace: the namespace whose services to return; None for all namespaces.
        include_nodes: whether to return pairs of a name and its nodes.
    """
    selected = [[name, nodes] for name, nodes in _services() if not node or node in nodes]
    names = set(
        names_in_namespace([name for name, _ in selected], script_resolve_name(NAME, namespace) if namespace else None)
    )
    return [[name, nodes] if include_nodes else name for name, nodes in selected if name in names]


def rosservice_find(service_type: str) -> list[str]:
    """Return the names of the services with a given type, except services whose nodes do not respond."""
    names = []
    for name, _ in _services():
        try:
            if get_service_type(name) == service_type:
                names.append(name)
        except ROSServiceIOException:
            continue
    return names


def get_service_class_by_name(service_name: str) -> Any:
    """Return the class of a service.

    Raises:
        ROSServiceException: no node provides the service, or there is no definition of its type.
    """
    type_name = get_service_type(service_name)
    if not type_name:
        raise ROSServiceException(f"Service [{service_name}] is not available.")
    cls = roslib.message.get_service_class(type_name)
    if cls is None:
        raise ROSServiceException(
            f"Unable to load type [{type_name}].\nHave you typed 'make' in [{type_name.partition('/')[0]}]?"
        )
    return cls


def get_service_args(service_name: str) -> str:
    """Return the names of a service's arguments; see `get_service_class_by_name` for errors."""
    return get_printable_message_args(get_service_class_by_name(service_name)._request_class())


def has_service_args(service_name: str, service_class: Any = None) -> bool:
    """Return whether a service has arguments."""
    cls = service_class or get_service_class_by_name(service_name)
    return len(cls._request_class.__slots__) > 0


def call_service(service_name: str, service_args: Any, service_class: Any = None) -> tuple[Any, Any]:
    """Call a service; start a node if the process has none.

    Args:
        service_name: name of the service.
        service_args: a list of the request's values, or a list that contains one mapping, name -> value.
        service_class: class of the service; None to find it from the service's type.

    Returns:
        The request and the response.

    Raises:
        ROSServiceException: the arguments are invalid, or the call failed.
        ROSServiceIOException: the service does not respond.
    """
    cls = service_class or get_service_class_by_name(service_name)
    request = cls._request_class()
    try:
        genpy.message.fill_message_args(
            request, service_args, keys={"now": rospy.get_rostime()} if rospy.core.is_initialized() else {}
        )
    except genpy.MessageException as error:

        def describe(value: Any) -> str:
            return f"{value} (type {type(value).__name__})"

        values_text = "".join(f"\n * {describe(arg)}" for arg in service_args)
        raise ROSServiceException(
            f"Incompatible arguments to call service:\n{error}\nProvided arguments are:{values_text or chr(10)}"
            f"\n\nService arguments are: [{get_printable_message_args(request)}]"
        ) from None
    if not rospy.core.is_initialized():
        rospy.init_node("rosservice", anonymous=True)
    try:
        return request, rospy.ServiceProxy(service_name, cls)(request)
    except rospy.ServiceException as error:
        raise ROSServiceException(str(error)) from error
    except genpy.SerializationError as error:
        raise ROSServiceException(
            f"Unable to send request. One of the fields has an incorrect type:\n  {error}"
        ) from error
    except rospy.ROSSerializationException as error:
        raise ROSServiceException(
            f"Unable to send request. One of the fields has an incorrect type:\n  {error}"
        ) from error


def _run_verb(verb: str, *words: str) -> None:
    code = _run(NAME, verb, *words)
    if code:
        sys.exit(code)


def _rosservice_type(service_name: str) -> None:
    _run_verb("type", service_name)


def _rosservice_node(service_name: str) -> None:
    _run_verb("node", service_name)


def _rosservice_uri(service_name: str) -> None:
    _run_verb("uri", service_name)


def _rosservice_args(service_name: str) -> None:
    _run_verb("args", service_name)


def _rosservice_info(service_name: str) -> None:
    _run_verb("info", service_name)


def _rosservice_list(namespace: str | None = None, print_nodes: bool = False) -> None:
    _run_verb("list", *(["-n"] if print_nodes else []), *([namespace] if namespace else []))


def _rosservice_call(service_name: str, service_args: Any, verbose: bool = False, service_class: Any = None) -> None:
    request, response = call_service(service_name, service_args, service_class)
    if verbose:
        print(f"{request}\n---")
    print(response)


def rosservicemain(argv: list[str] | None = None) -> None:
    """Run the tool with a command line; None for the process's own."""
    _main(NAME, argv)
