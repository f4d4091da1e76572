"""Checks of a running system: unreachable nodes and services, and clocks. This module has no side effects."""

from __future__ import annotations

from collections.abc import Iterator

from pyros1.doctor.facts import HANGS, REFUSED, TIMEOUT, UNRESOLVED, Machine, NodeFacts, System
from pyros1.doctor.finding import ERROR, WARNING, Finding
from pyros1.doctor.machine_checks import external_address
from pyros1.ground.errors import ProtocolError
from pyros1.net.connectivity import is_loopback
from pyros1.net.hosts import parse_uri

MAX_CLOCK_OFFSET = 1.5
"""Maximum difference between clocks in seconds. Nodes report the time with a resolution of one second."""


def check_connectivity(system: System, machine: Machine) -> list[Finding]:
    """Return the problems with the addresses, services and clocks of nodes."""
    checks = (
        _check_unresolved_hosts,
        _check_refusing_nodes,
        _check_hanging_nodes,
        _check_unreachable_hosts,
        _check_loopback_addresses,
        _check_services,
        _check_clocks,
    )
    return [finding for check in checks for finding in check(system, machine)]


def _failed_nodes(system: System, kind: str) -> dict[str, list[str]]:
    """Return the names of the nodes whose `Failure` is of a given kind, by host."""
    nodes_by_host: dict[str, list[str]] = {}
    for name, node in sorted(system.nodes.items()):
        if node.failure is not None and node.failure.kind == kind:
            nodes_by_host.setdefault(node.host, []).append(name)
    return nodes_by_host


def _check_unresolved_hosts(system: System, machine: Machine) -> Iterator[Finding]:
    for host, nodes in _failed_nodes(system, UNRESOLVED).items():
        yield Finding(
            "unknown-host",
            ERROR,
            f"Nodes are registered under the host name [{host}], which is unknown here",
            f"on their machine export ROS_IP=<its address>{_local_processes_note(machine, host)} and restart them, "
            f"or add a line 'ADDRESS {host}' to /etc/hosts here",
            tuple(nodes),
        )


def _local_processes_note(machine: Machine, host: str) -> str:
    """Return a note about processes on this machine that use ``host`` as their address, since these must be fixed."""
    descriptions = [f"{process.name}, pid {process.pid}" for process in machine.processes if process.host == host]
    return f" (here: {external_address(machine)}; {'; '.join(descriptions)})" if descriptions else ""


def _check_refusing_nodes(system: System, machine: Machine) -> Iterator[Finding]:
    nodes = [
        (name, node) for name, node in sorted(system.nodes.items()) if node.failure and node.failure.kind == REFUSED
    ]
    if nodes:
        yield Finding(
            "dead-node",
            ERROR,
            "Could not contact the following nodes: they are registered, but refuse connections",
            "if they have exited: pyros1 node cleanup; if they are running, their address is wrong: restart them with "
            "ROS_IP=<address of their machine>",
            tuple(f"{name} ({node.uri})" for name, node in nodes),
        )


def _check_hanging_nodes(system: System, machine: Machine) -> Iterator[Finding]:
    for host, nodes in _failed_nodes(system, HANGS).items():
        yield Finding(
            "hung-node",
            ERROR,
            f"Nodes at [{host}] accept connections, but do not answer: they hang or are suspended",
            "on their machine: kill -CONT PID if they are suspended (state T in ps), otherwise restart them",
            tuple(f"{name} ({system.nodes[name].uri})" for name in nodes),
        )


def _check_unreachable_hosts(system: System, machine: Machine) -> Iterator[Finding]:
    for host, nodes in _failed_nodes(system, TIMEOUT).items():
        address_text = ", ".join(system.nodes[nodes[0]].addresses or ())
        local_note = _local_processes_note(machine, host)
        yield Finding(
            "unreachable-host",
            ERROR,
            f"Nodes at [{host}]{f' ({address_text})' if address_text not in ('', host) else ''} do not answer in time",
            f"ping {host}: if it answers, a firewall blocks the connection; if not, that machine is "
            f"off or its address is wrong: export ROS_IP=<its address> there{local_note} and restart the nodes",
            tuple(nodes),
        )
    descriptions = [
        f"{name} ({node.uri}): {node.failure.text}"
        for name, node in sorted(system.nodes.items())
        if node.failure and node.failure.kind not in (UNRESOLVED, REFUSED, TIMEOUT, HANGS)
    ]
    if descriptions:
        yield Finding(
            "broken-node",
            ERROR,
            "The following nodes do not answer like ROS nodes",
            "another program may be using their port: pyros1 node cleanup, then restart them",
            tuple(descriptions),
        )


def _check_loopback_addresses(system: System, machine: Machine) -> Iterator[Finding]:
    """Check for nodes that can only be reached from their own machine, in a system with several machines."""
    local_only_nodes = [name for name, node in sorted(system.nodes.items()) if _is_local_only(node)]
    # A node that does not respond may be running on this machine with an incorrect address.
    responding = {name: node for name, node in system.nodes.items() if node.failure is None}
    on_other_machines = [name for name, node in responding.items() if node.addresses and not _is_here(node, machine)]
    is_master_remote = not _is_master_local(system, machine)
    if local_only_nodes and (on_other_machines or is_master_remote):
        remote_text = "the master is" if is_master_remote else f"nodes are, for example {on_other_machines[0]}"
        yield Finding(
            "loopback-node",
            ERROR,
            "The following nodes are registered with a loopback address, which only their own machine can use, "
            f"but {remote_text} on another machine",
            "on their machine: unset ROS_HOSTNAME, export ROS_IP=<address of that machine, here "
            f"{external_address(machine)}>, check /etc/hosts for 127.0.1.1, and restart them",
            tuple(f"{name} ({system.nodes[name].uri})" for name in local_only_nodes),
        )


def _is_local_only(node: NodeFacts) -> bool:
    return bool(node.addresses) and all(map(is_loopback, node.addresses or ()))


def _is_here(node: NodeFacts, machine: Machine) -> bool:
    return any(is_loopback(address) or address in machine.interfaces for address in node.addresses or ())


def _is_master_local(system: System, machine: Machine) -> bool:
    try:
        host, _ = parse_uri(system.master_uri)
    except ProtocolError:
        return True
    addresses = machine.resolved.get(host) or (host,)
    return any(is_loopback(address) or address in machine.interfaces for address in addresses)


def _check_services(system: System, machine: Machine) -> Iterator[Finding]:
    descriptions = [
        f"service [{name}] appears to be malfunctioning: {failure.text}"
        for name, (_, failure) in sorted(system.services.items())
        if failure is not None and not _is_provider_down(system, name)
    ]
    if descriptions:
        yield Finding(
            "service",
            ERROR,
            "Errors connecting to the following services:",
            "restart the nodes that provide them (`pyros1 service node NAME` prints the node)",
            tuple(descriptions),
        )


def _is_provider_down(system: System, service: str) -> bool:
    """Return whether none of a service's providers responds. Another check reports this, once per node."""
    providers = [system.nodes[name] for name in system.state.services.get(service, ()) if name in system.nodes]
    return bool(providers) and all(node.failure is not None for node in providers)


def _check_clocks(system: System, machine: Machine) -> Iterator[Finding]:
    offsets_by_host: dict[str, float] = {}
    for node in system.nodes.values():
        if node.clock_offset is not None and abs(node.clock_offset) > MAX_CLOCK_OFFSET:
            offsets_by_host.setdefault(node.host, node.clock_offset)
    for host, offset in sorted(offsets_by_host.items()):
        yield Finding(
            "clock-skew",
            WARNING if system.use_sim_time else ERROR,
            f"the clock of [{host}] is {abs(offset):.0f} s {'ahead of' if offset > 0 else 'behind'} this machine's: "
            "tf and other programs that compare time stamps will fail",
            "synchronize the clocks: chrony on both machines, or now: sudo ntpdate pool.ntp.org",
        )
