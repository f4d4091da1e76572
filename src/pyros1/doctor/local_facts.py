"""Collects facts about this machine and this shell."""

from __future__ import annotations

import os
import re
import shutil
import socket
import sys
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from time import monotonic

from pyros1.doctor.concurrent import run_concurrently
from pyros1.doctor.disk import folder_size
from pyros1.doctor.facts import Disk, LocalProcess, Machine
from pyros1.doctor.probe import resolve_host
from pyros1.ground.errors import Error, SettingError
from pyros1.launch.running.logs import log_folder, ros_home
from pyros1.net.hosts import DEFAULT_MASTER_URI, addresses_from_environment, interface_addresses, parse_uri
from pyros1.net.xmlrpc_client import XmlRpcClient
from pyros1.wire.local import is_local_enabled

MASTER_PORTS = range(11311, 11321)
"""Ports on this machine on which to look for masters, in addition to the port in ROS_MASTER_URI."""
_TIMEOUT = 2.0
_LOG_SIZE_TIMEOUT = 1.0


def collect_machine(environ: Mapping[str, str]) -> Machine:
    """Return the facts about this machine. Collecting them takes up to about three seconds.

    Args:
        environ: the environment variables.
    """
    hostname = socket.gethostname()
    host_names = {hostname, environ.get("ROS_HOSTNAME", ""), environ.get("ROS_IP", "")}
    master_address = _host_and_port(environ.get("ROS_MASTER_URI") or DEFAULT_MASTER_URI)
    if master_address is not None:
        host_names.add(master_address[0])
    processes = ros_processes()
    host_names |= {address[0] for address in (_host_and_port(process.master_uri) for process in processes) if address}
    addresses_by_host = run_concurrently({name: partial(resolve_host, name) for name in host_names if name}, _TIMEOUT)
    logs_path = log_folder(environ)
    missing_folders = [
        part for part in environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if part and not os.path.isdir(part)
    ]
    return Machine(
        environ=environ,
        hostname=hostname,
        interfaces=interface_addresses(),
        resolved={
            name: None if isinstance(result, Exception) else result for name, result in addresses_by_host.items()
        },
        missing_paths=missing_folders,
        disks=[
            _disk_facts(folder)
            for folder in dict.fromkeys((_closest_existing(logs_path), _closest_existing(ros_home(environ))))
        ],
        log_folder=str(logs_path),
        log_size=folder_size(logs_path.resolve(), on_disk=True, deadline=monotonic() + _LOG_SIZE_TIMEOUT)
        if logs_path.exists()
        else 0,
        masters=local_masters(environ),
        processes=processes,
        python=(sys.version_info[0], sys.version_info[1]),
        setting_problems=setting_problems(environ),
    )


def setting_problems(environ: Mapping[str, str]) -> list[str]:
    """Return messages about pyros1's environment variables whose values prevent nodes from starting."""
    problems = []
    for name in ("PYROS1_ALLOW", "PYROS1_BIND", "PYROS1_PORTS", "PYROS1_TRANSPORTS"):
        value = environ.get(name, "")
        try:
            addresses_from_environment({name: value}, {})
            is_local_enabled(value if name == "PYROS1_TRANSPORTS" else "")
        except SettingError as error:
            problems.append(str(error))
    return problems


def _host_and_port(uri: str) -> tuple[str, int] | None:
    try:
        return parse_uri(uri)
    except Error:
        return None


def _closest_existing(folder: Path) -> Path:
    """Return the folder if it exists, otherwise its closest existing parent."""
    while not folder.is_dir() and folder != folder.parent:
        folder = folder.parent
    return folder


def _disk_facts(folder: Path) -> Disk:
    usage = shutil.disk_usage(folder)
    return Disk(str(folder), usage.free, usage.total, os.access(folder, os.W_OK | os.X_OK))


def local_masters(environ: Mapping[str, str]) -> list[str]:
    """Return the URIs of the masters that are running on this machine."""
    ports = dict.fromkeys(MASTER_PORTS)
    configured_address = _host_and_port(environ.get("ROS_MASTER_URI") or DEFAULT_MASTER_URI)
    if configured_address is not None and configured_address[0] in ("localhost", "127.0.0.1", socket.gethostname()):
        ports[configured_address[1]] = None
    uris = [f"http://localhost:{port}/" for port in ports]
    results = run_concurrently({uri: partial(_is_master, uri) for uri in uris}, _TIMEOUT)
    return [uri for uri, result in results.items() if result is True]


def _is_master(uri: str) -> bool:
    client = XmlRpcClient(uri, timeout=_TIMEOUT / 2)
    try:
        return bool(client.call("getUri", "/roswtf")[0] == 1)  # nodes do not have this method
    except (Error, LookupError, TypeError):
        return False
    finally:
        client.close()


def ros_processes() -> list[LocalProcess]:
    """Return programs with a ROS_MASTER_URI and a listening socket, such as nodes. This only works on Linux."""
    listening = _listening_sockets()
    processes = []
    for folder in Path("/proc").glob("[0-9]*"):
        if int(folder.name) == os.getpid():
            continue
        try:
            environ = _read_environ(folder)
            if "ROS_MASTER_URI" not in environ or not _has_socket(folder, listening):
                continue
            command_line = (folder / "cmdline").read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue  # another user's process, or one that has exited
        host = environ.get("ROS_HOSTNAME") or environ.get("ROS_IP") or ""
        processes.append(LocalProcess(int(folder.name), _program_name(command_line), environ["ROS_MASTER_URI"], host))
    return sorted(processes)


def _read_environ(folder: Path) -> dict[str, str]:
    entries = (folder / "environ").read_bytes().decode(errors="replace").split("\0")
    return dict(entry.split("=", 1) for entry in entries if "=" in entry)


def _has_socket(folder: Path, sockets: set[str]) -> bool:
    for name in os.listdir(folder / "fd"):
        try:
            if os.readlink(folder / "fd" / name) in sockets:
                return True
        except OSError:
            continue
    return False


def _listening_sockets() -> set[str]:
    """Return the names that listening sockets have in ``/proc/PID/fd``."""
    names = set()
    for table_file in ("/proc/net/tcp", "/proc/net/tcp6"):
        try:
            rows = Path(table_file).read_text().splitlines()[1:]
        except OSError:
            continue
        names |= {f"socket:[{row[9]}]" for row in map(str.split, rows) if len(row) > 9 and row[3] == "0A"}
    return names


def _program_name(command_line: list[str]) -> str:
    """Return the display name of a command line, including the script's name if Python runs one."""
    name = os.path.basename(command_line[0])
    if re.fullmatch(r"python[\d.]*", name):
        script = next((arg for arg in command_line[1:] if arg and not arg.startswith("-")), "")
        name = f"{name} {os.path.basename(script)}".strip()
    return name


def check_packages(environ: Mapping[str, str]) -> list[str]:
    """Return the problems in the ``package.xml`` files of all packages."""
    # Only `pyros1 wtf --all` needs these imports. defusedxml has no stubs.
    from defusedxml.ElementTree import ParseError, parse  # type: ignore[import-untyped]  # noqa: PLC0415

    from pyros1.finding.packages import PackageIndex  # noqa: PLC0415

    problems = []
    for name, folder in sorted(PackageIndex(environ).paths().items()):
        file = folder / "package.xml"
        if not file.is_file():
            continue
        try:
            root = parse(file).getroot()
        except (ParseError, ValueError, LookupError, OSError) as error:  # LookupError: an unknown encoding
            problems.append(f"{name} ({file}): {error}")
            continue
        missing_tags = [tag for tag in ("name", "version", "description") if root.find(tag) is None]
        if missing_tags:
            problems.append(f"{name} ({file}): <{'>, <'.join(missing_tags)}> is missing")
    return problems
