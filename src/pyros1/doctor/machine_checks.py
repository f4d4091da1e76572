"""Checks of this machine and this shell, which need no master and have no side effects."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from pyros1.doctor.disk import format_size
from pyros1.doctor.facts import Machine
from pyros1.doctor.finding import ERROR, WARNING, Finding
from pyros1.ground.errors import ProtocolError
from pyros1.net.connectivity import is_loopback
from pyros1.net.hosts import DEFAULT_MASTER_URI, parse_uri

MIN_FREE_BYTES = 100 << 20
"""Minimum number of free bytes on the disk of the log files."""
MAX_LOG_SIZE = 1 << 30
"""Size of the log folder in bytes above which a warning is printed, as in the stock tools."""
_MAX_ITEMS = 10
"""Maximum number of items that a finding lists."""
MIN_PYTHON = (3, 10)


def check_machine(machine: Machine) -> list[Finding]:
    """Return the problems of a machine and its environment."""
    checks = (
        _check_master_uri,
        _check_settings,
        _check_address_variables,
        _check_machine_name,
        _check_package_path,
        _check_disks,
        _check_masters,
        _check_python_version,
        _report_collected_problems,
    )
    return [finding for check in checks for finding in check(machine)]


def external_address(machine: Machine) -> str:
    """Return an address at which other machines may reach this one, for use in messages."""
    return next((address for address in machine.interfaces if not is_loopback(address)), "<address of this machine>")


def _check_master_uri(machine: Machine) -> Iterator[Finding]:
    uri = machine.environ.get("ROS_MASTER_URI")
    if not uri:
        return  # the default is used
    try:
        host, _ = parse_uri(uri)
    except ProtocolError:
        yield Finding(
            "master-uri",
            ERROR,
            f"ROS_MASTER_URI [{uri}] is not a valid URL",
            f"export ROS_MASTER_URI={DEFAULT_MASTER_URI}, or the address of the robot in place of localhost",
        )
        return
    if machine.resolved.get(host, ()) is None:
        yield Finding(
            "master-host",
            ERROR,
            f"Cannot resolve hostname in ROS_MASTER_URI [{uri}]: unknown host {host}",
            f"use the master's IP address in ROS_MASTER_URI, or add a line 'ADDRESS {host}' to /etc/hosts",
        )


def _check_settings(machine: Machine) -> Iterator[Finding]:
    for problem in machine.setting_problems:
        yield Finding(
            "setting", ERROR, f"no pyros1 node can start in this shell: {problem}", "correct or unset the variable"
        )


def _check_address_variables(machine: Machine) -> Iterator[Finding]:
    name, address = machine.environ.get("ROS_HOSTNAME"), machine.environ.get("ROS_IP")
    if name is not None and address is not None and name != address:
        yield Finding(
            "both-set",
            WARNING,
            f"both ROS_HOSTNAME [{name}] and ROS_IP [{address}] are set: ROS_HOSTNAME is used",
            "unset one of them",
        )
    ip = external_address(machine)
    for variable, value in (("ROS_IP", address), ("ROS_HOSTNAME", name)):
        if value is None or (variable == "ROS_IP" and name):
            continue
        resolved = machine.resolved.get(value)
        if not value or "://" in value:
            yield Finding(
                "own-address",
                ERROR,
                f"{variable} [{value}] is neither a host name nor an IP address",
                f"export ROS_IP={ip}, or unset {variable}",
            )
        elif resolved is None:
            yield Finding(
                "own-address",
                ERROR,
                f"{variable} may be incorrect: [{value}] cannot be resolved, so no node can reach nodes started in "
                "this shell",
                f"export ROS_IP={ip} and unset ROS_HOSTNAME, or add '{ip} {value}' to /etc/hosts on all machines",
            )
        elif not any(is_loopback(ip_address) or ip_address in machine.interfaces for ip_address in resolved):
            yield Finding(
                "own-address",
                ERROR,
                f"{variable} may be incorrect: {variable} [{value}] does not appear to be an address of a local "
                f"network interface (one of {', '.join(machine.interfaces)})",
                f"export {variable}={ip}, or unset {variable}; then restart the nodes started in this shell",
            )
        elif all(map(is_loopback, resolved)) and not _is_master_local(machine):
            yield Finding(
                "own-address",
                ERROR,
                f"{variable} [{value}] is only valid on this machine, but the master is on another one: "
                "nodes there cannot reach nodes started in this shell",
                f"export ROS_IP={ip} and unset ROS_HOSTNAME; then restart the nodes started in this shell",
            )


def _is_master_local(machine: Machine) -> bool:
    try:
        host, _ = parse_uri(machine.environ.get("ROS_MASTER_URI") or DEFAULT_MASTER_URI)
    except ProtocolError:
        return True  # reported by another check
    addresses = machine.resolved.get(host)
    return addresses is None or any(is_loopback(address) or address in machine.interfaces for address in addresses)


def _check_machine_name(machine: Machine) -> Iterator[Finding]:
    """Check the machine's name, which nodes use as their address if neither variable is set."""
    if machine.environ.get("ROS_HOSTNAME") or machine.environ.get("ROS_IP"):
        return
    resolved, ip = machine.resolved.get(machine.hostname), external_address(machine)
    if resolved is None:
        yield Finding(
            "own-name",
            ERROR,
            f"the name of this machine [{machine.hostname}] cannot be resolved, and nodes use it as their address",
            f"export ROS_IP={ip}, or add a line '127.0.0.1 {machine.hostname}' to /etc/hosts",
        )
    elif all(map(is_loopback, resolved)) and not _is_master_local(machine):
        yield Finding(
            "own-name",
            WARNING,
            f"the name of this machine [{machine.hostname}] resolves to {', '.join(resolved)} here, and nodes use it "
            "as their address: other machines may not know the name, or resolve it to themselves",
            f"export ROS_IP={ip}",
        )
    elif not any(is_loopback(ip_address) or ip_address in machine.interfaces for ip_address in resolved):
        yield Finding(
            "own-name",
            ERROR,
            f"the name of this machine [{machine.hostname}] resolves to {', '.join(resolved)}, which is not its "
            "address",
            f"correct the line of {machine.hostname} in /etc/hosts, or export ROS_IP={ip}",
        )


def _check_package_path(machine: Machine) -> Iterator[Finding]:
    if machine.missing_paths:
        path = machine.environ.get("ROS_PACKAGE_PATH", "")
        yield Finding(
            "package-path",
            ERROR,
            f"Not all paths in ROS_PACKAGE_PATH [{path}] point to an existing directory: ",
            "remove them from ROS_PACKAGE_PATH, or source the setup file of the workspace again",
            tuple(machine.missing_paths),
        )


def _check_disks(machine: Machine) -> Iterator[Finding]:
    for disk in machine.disks:
        if not disk.writable:
            yield Finding(
                "not-writable",
                ERROR,
                f"[{disk.folder}] cannot be written to: nodes cannot log",
                f"sudo chown -R $USER {disk.folder}, or set ROS_LOG_DIR to another folder",
            )
        elif disk.free < MIN_FREE_BYTES:
            yield Finding(
                "disk-full",
                ERROR,
                f"the disk of [{disk.folder}] is full: {format_size(disk.free)} of {format_size(disk.total)} are free",
                "free some space: `pyros1 clean purge` removes old logs; large bags may also fill the disk",
            )
    if machine.log_size > MAX_LOG_SIZE:
        yield Finding(
            "log-size",
            WARNING,
            f"the log folder [{machine.log_folder}] uses {format_size(machine.log_size)}",
            "pyros1 clean purge --size 500",
        )


def _check_masters(machine: Machine) -> Iterator[Finding]:
    if len(machine.masters) > 1:
        yield Finding(
            "several-masters",
            WARNING,
            f"{len(machine.masters)} masters are running on this machine; nodes of one do not see those of another",
            "stop the unwanted ones, or check that ROS_MASTER_URI is the same in all shells",
            tuple(machine.masters),
        )
    master_uri = machine.environ.get("ROS_MASTER_URI") or DEFAULT_MASTER_URI
    other_processes = [
        process
        for process in machine.processes
        if process.master_uri and not _is_same_uri(process.master_uri, master_uri, machine)
    ]
    if other_processes:
        yield Finding(
            "other-master-uri",
            WARNING,
            f"programs on this machine use a different ROS_MASTER_URI than this shell [{master_uri}]",
            "if they belong together, restart them with the same ROS_MASTER_URI",
            _shorten(f"{process.name} (pid {process.pid}): {process.master_uri}" for process in other_processes),
        )


def _shorten(items: Iterable[str]) -> tuple[str, ...]:
    """Return the first few items, followed by the number of the others."""
    all_items = list(items)
    remaining = len(all_items) - _MAX_ITEMS
    return (*all_items[:_MAX_ITEMS], *([f"and {remaining} more"] if remaining > 0 else []))


def _is_same_uri(uri: str, other_uri: str, machine: Machine) -> bool:
    try:
        (host, port), (other_host, other_port) = parse_uri(uri), parse_uri(other_uri)
    except ProtocolError:
        return uri == other_uri
    if port != other_port or host == other_host:
        return port == other_port
    addresses = [{*(machine.resolved.get(name) or (name,))} for name in (host, other_host)]
    return not addresses[0].isdisjoint(addresses[1]) or all(_is_here(machine, address_set) for address_set in addresses)


def _is_here(machine: Machine, addresses: Iterable[str]) -> bool:
    return all(is_loopback(address) or address in machine.interfaces for address in addresses)


def _check_python_version(machine: Machine) -> Iterator[Finding]:
    if machine.python < MIN_PYTHON:
        yield Finding(
            "python",
            ERROR,
            f"this is Python {machine.python[0]}.{machine.python[1]}, but pyros1 needs 3.10 or newer",
            "install a newer Python, then install pyros1 with it",
        )


def _report_collected_problems(machine: Machine) -> Iterator[Finding]:
    if machine.launch_problems:
        yield Finding(
            "launch-file",
            ERROR,
            "the launch files have problems:",
            "correct them, and check them with `pyros1 launch --check FILE`",
            tuple(machine.launch_problems),
        )
    if machine.package_problems:
        yield Finding(
            "package",
            ERROR,
            "these packages cannot be used:",
            "correct their package.xml",
            tuple(machine.package_problems),
        )
