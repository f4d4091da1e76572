"""rosnode, by pyros1: lists, pings and shuts down nodes (https://wiki.ros.org/rosnode)."""

from __future__ import annotations

import itertools
import socket
import sys
import time
from collections.abc import Iterable, Iterator
from typing import Any
from urllib.parse import urlparse

import rosgraph
from rosgraph.names import script_resolve_name

from pyros1.drop_in.commands import main as _main
from pyros1.drop_in.commands import run as _run
from pyros1.drop_in.module_attributes import module_getattr
from pyros1.graph import NodeApi
from pyros1.ground.errors import DeadlineError, Error

__getattr__ = module_getattr(__name__)

NAME = "rosnode"
ID = "/rosnode"
_TIMEOUT = 3.0
_caller_apis: dict[str, str] = {}


class ROSNodeException(Exception):
    """A node is unknown, or rejects a call."""


class ROSNodeIOException(ROSNodeException):
    """The master does not respond."""


def _succeed(args: tuple[int, str, Any]) -> Any:
    """Return the value in an API's reply; raise ROSNodeException if the call failed."""
    code, message, value = args
    if code != 1:
        raise ROSNodeException(f"remote call failed: {message}")
    return value


def _system_state(master: Any = None) -> Any:
    try:
        return (master or rosgraph.Master(ID)).getSystemState()
    except OSError:
        raise ROSNodeIOException("Unable to communicate with master!") from None


def _registered_nodes(state: Any) -> Iterator[str]:
    return itertools.chain.from_iterable(nodes for table in state for _, nodes in table)


def get_api_uri(master: Any, caller_id: str, skip_cache: bool = False) -> str | None:
    """Return the address of a node's API; None if the master does not know it."""
    uri = None if skip_cache else _caller_apis.get(caller_id)
    if uri is None:
        try:
            uri = str(master.lookupNode(caller_id))
        except rosgraph.MasterException:
            return None
        except OSError:
            raise ROSNodeIOException("Unable to communicate with master!") from None
        _caller_apis[caller_id] = uri
    return uri


def lookup_uri(master: Any, system_state: Any, topic: str, uri: str) -> str:
    """Return the address of a node that uses a topic, preceded by the node's name if that is known."""
    for nodes in (nodes for table in system_state[:2] for name, nodes in table if name == topic):
        for node in nodes:
            if get_api_uri(master, node) == uri:
                return f"{node} ({uri})"
    return uri


def get_node_names(namespace: str | None = None) -> list[str]:
    """Return the names of all nodes, or of the nodes in a namespace, sorted."""
    names = sorted(set(_registered_nodes(_system_state())))
    if namespace:
        prefix = namespace.rstrip("/") + "/"
        names = [name for name in names if name.startswith(prefix) or name == namespace]
    return names


def get_machines_by_nodes() -> list[str]:
    """Return the hosts on which nodes run."""
    return list({host for _, host in _hosts()})


def get_nodes_by_machine(machine: str) -> list[str]:
    """Return the nodes on a host; raises ROSNodeException if the host's name cannot be resolved."""
    try:
        addresses = {address_info[4][0] for address_info in socket.getaddrinfo(machine, None)}
    except OSError:
        raise ROSNodeException(f"cannot resolve machine name [{machine}] to address") from None
    nodes = []
    for node, host in _hosts():
        try:
            is_same_host = machine == host or not addresses.isdisjoint(
                address_info[4][0] for address_info in socket.getaddrinfo(host, None)
            )
        except OSError:
            is_same_host = False
        if is_same_host:
            nodes.append(node)
    return nodes


def _hosts() -> Iterator[tuple[str, str]]:
    master = rosgraph.Master(ID)
    for node in get_node_names():
        uri = get_api_uri(master, node)
        host = urlparse(uri).hostname if uri else None
        if host:
            yield node, host


def kill_nodes(node_names: Iterable[str]) -> tuple[list[str], list[str]]:
    """Shut down nodes.

    Returns:
        The names of the nodes that were shut down, and of the nodes that are unknown or do not respond.
    """
    master = rosgraph.Master(ID)
    success, fail = [], []
    for name in node_names:
        uri = get_api_uri(master, name, skip_cache=True)
        try:
            if uri is None:
                raise ROSNodeException(name)
            api = NodeApi(ID, uri, _TIMEOUT)
            try:
                api.shutdown("user request")
            finally:
                api.close()
            success.append(name)
        except (DeadlineError, ROSNodeException):
            fail.append(name)
        except (Error, OSError):
            success.append(name)  # the node has probably ended before it could respond
    return success, fail


def rosnode_listnodes(namespace: str | None = None, list_uri: bool = False, list_all: bool = False) -> None:
    """Print the names of nodes, their addresses, or both."""
    print(_sub_rosnode_listnodes(namespace, list_uri, list_all))


def _sub_rosnode_listnodes(namespace: str | None = None, list_uri: bool = False, list_all: bool = False) -> str:
    names, master = get_node_names(namespace), rosgraph.Master(ID)
    if list_all:
        return "\n".join(f"{get_api_uri(master, name) or 'unknown address'} \t{name}" for name in names)
    if list_uri:
        return "\n".join(get_api_uri(master, name) or "unknown address" for name in names)
    return "\n".join(names)


def rosnode_ping(node_name: str, max_count: int | None = None, verbose: bool = False, skip_cache: bool = False) -> bool:
    """Ping a node once a second.

    Args:
        max_count: number of pings; None to continue until the program is interrupted.
        verbose: whether to print the times.
        skip_cache: whether to ask the master for the node's address even if the address is cached.

    Returns:
        Whether the node answered.
    """
    master = rosgraph.Master(ID)
    uri = get_api_uri(master, node_name, skip_cache)
    if uri is None:
        print(f"cannot ping [{node_name}]: unknown node", file=sys.stderr)
        return False
    if verbose:
        print(f"pinging {node_name} with a timeout of {_TIMEOUT}s")
    api = NodeApi(ID, uri, _TIMEOUT)
    total, count = 0.0, 0
    try:
        while True:
            try:
                milliseconds = api.ping() * 1000
            except (Error, OSError):
                if not skip_cache:
                    current_uri = get_api_uri(master, node_name, skip_cache=True)
                    if current_uri not in (None, uri):
                        return rosnode_ping(node_name, max_count, verbose, skip_cache=True)
                print(f"ERROR: connection refused to [{uri}]", file=sys.stderr)
                return False
            total, count = total + milliseconds, count + 1
            if verbose:
                print(f"xmlrpc reply from {uri}\ttime={milliseconds:f}ms")
            if max_count and count >= max_count:
                break
            time.sleep(1.0)
    except KeyboardInterrupt:
        pass
    finally:
        api.close()
    if verbose and count > 1:
        print(f"ping average: {total / count:f}ms")
    return True


def rosnode_ping_all(verbose: bool = False, skip_cache: bool = False) -> tuple[list[str], list[str]]:
    """Ping all nodes once; return the nodes that answered, and the nodes that did not."""
    names = get_node_names()
    if verbose:
        print("Will ping the following nodes: \n" + "".join(f" * {name}\n" for name in names))
    pinged: list[str] = []
    unpinged: list[str] = []
    for name in names:
        (pinged if rosnode_ping(name, max_count=1, verbose=verbose, skip_cache=skip_cache) else unpinged).append(name)
    return pinged, unpinged


def cleanup_master_blacklist(master: Any, blacklist: Iterable[str]) -> None:
    """Remove from the master all registrations of the nodes in ``blacklist``."""
    names = set(blacklist)
    for name in sorted(names & set(_registered_nodes(_system_state(master)))):
        print(f"Unregistering {name}")
    _unregister(master, names)


def _unregister(master: Any, names: set[str]) -> None:
    publishers, subscribers, services = _system_state(master)
    for name in sorted(names & set(_registered_nodes((publishers, subscribers, services)))):
        uri = get_api_uri(master, name, True) or ""  # the node may have been restarted
        node = rosgraph.Master(name, master.master_uri)
        for topic, nodes in publishers:
            if name in nodes:
                node.unregisterPublisher(topic, uri)
        for topic, nodes in subscribers:
            if name in nodes:
                node.unregisterSubscriber(topic, uri)
        for service, nodes in services:
            if name in nodes:
                node.unregisterService(service, master.lookupService(service))


def cleanup_master_whitelist(master: Any, whitelist: Iterable[str]) -> None:
    """Remove from the master all registrations of nodes that are not in ``whitelist``."""
    _unregister(master, set(_registered_nodes(_system_state(master))) - set(whitelist))


def rosnode_cleanup() -> None:
    """Ask on the terminal whether to remove the registrations of nodes that do not respond, and if so, remove them."""
    _run(NAME, "cleanup")


def get_node_info_description(node_name: str) -> str:
    """Return the master's information about a node, as text."""
    master = rosgraph.Master(ID)
    publishers, subscribers, services = _system_state(master)
    types = {entry[0]: entry[1] for entry in master.getPublishedTopics("/")}

    def topics(table: Any) -> list[str]:
        names = sorted(name for name, nodes in table if node_name in nodes)
        return [f" * {name} [{types.get(name, 'unknown type')}]" for name in names]

    def rows(title: str, lines: list[str]) -> str:
        return f"{title}: " + ("\n" + "\n".join(lines) if lines else "None") + "\n"

    provided_services = [f" * {name}" for name in sorted(name for name, nodes in services if node_name in nodes)]
    published, subscribed = rows("Publications", topics(publishers)), rows("Subscriptions", topics(subscribers))
    return f"Node [{node_name}]\n{published}\n{subscribed}\n{rows('Services', provided_services)}"


def get_node_connection_info_description(node_api: str, master: Any) -> str:
    """Return a node's process id and connections, as text.

    Raises:
        ROSNodeIOException: the node does not respond.
    """
    state = _system_state(master)
    api = NodeApi(ID, node_api, _TIMEOUT)
    try:
        text = f"Pid: {api.pid()}\n"
        connections = api.connections()
    except (Error, OSError):
        raise ROSNodeIOException(f"Communication with node[{node_api}] failed!") from None
    finally:
        api.close()
    lines = []
    direction_names = {"o": "outbound", "i": "inbound", "b": "inbound and outbound"}
    for connection in connections:
        peer_description = lookup_uri(master, state, connection.topic, connection.destination)
        socket_text = (
            ""
            if connection.local_port is None
            else f" ({connection.local_port} - {connection.peer}) [{connection.socket}]"
        )
        lines.append(f" * topic: {connection.topic}\n    * to: {peer_description}\n")
        if connection.connected:
            lines.append(
                f"    * direction: {direction_names.get(connection.direction, connection.direction)}{socket_text}\n"
            )
        lines.append(f"    * transport: {connection.transport}\n")
    return text + ("Connections:\n" + "".join(lines) if lines else "")


def rosnode_info(node_name: str, quiet: bool = False) -> None:
    """Print what the master and the node itself report about the node; with `quiet`, only what the master reports.

    Raises:
        ROSNodeIOException: the node does not respond.
    """
    name = script_resolve_name(NAME, node_name)
    master = rosgraph.Master(ID)
    print("-" * 80)
    print(get_node_info_description(name))
    uri = get_api_uri(master, name, True)
    if not uri:
        print(f"cannot contact [{name}]: unknown node", file=sys.stderr)
    elif not quiet:
        print(f"\ncontacting node {uri} ...")
        print(get_node_connection_info_description(uri, master))


def rosnode_debugnode(node_name: str, quiet: bool = False) -> None:
    """Do the same as `rosnode_info`."""
    rosnode_info(node_name, quiet)


def rosnodemain(argv: list[str] | None = None) -> None:
    """Run the tool with a command line (None for the process's own), then exit."""
    _main(NAME, argv)
    sys.exit(0)
