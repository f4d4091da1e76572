"""Determines the addresses that a process advertises and listens on, and the master's URI (facts N18-N26;
https://wiki.ros.org/ROS/NetworkSetup, https://wiki.ros.org/ROS/EnvironmentVariables).
"""

from __future__ import annotations

import re
import socket
import struct
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

from pyros1.ground.errors import ProtocolError, SettingError
from pyros1.net.resolve import direct_addresses, resolve_host

if TYPE_CHECKING:
    from pyros1.net.allowlist import Networks
    from pyros1.net.ports import PortRange

DEFAULT_MASTER_URI: Final = "http://localhost:11311"
WILDCARD_ADDRESSES: Final = ("0.0.0.0", "::")
"""Addresses that mean: listen on all addresses of this machine."""

_URI: Final = re.compile(
    r"([A-Za-z][A-Za-z0-9+.-]*)://(?:[^/@\s]*@)?(\[[0-9A-Fa-f:.%\w]+\]|[^/:@\s\[\]]+)(?::([0-9]*))?(?:[/?#]\S*)?\Z"
)
_DEFAULT_PORTS: Final = {"http": 80}


class LocalAddress(NamedTuple):
    """The addresses at which this process can be reached.

    Attributes:
        advertised: host name or address to use in URIs.
        bind: address to listen on.
        family: address family of ``bind``: ``socket.AF_INET`` or ``socket.AF_INET6``.
        warnings: messages about suspicious values in the environment.
        ports: ports to choose from; None for any.
        allowed: networks that may connect; None for all.
    """

    advertised: str
    bind: str
    family: int
    warnings: Sequence[str] = ()
    ports: PortRange | None = None
    allowed: Networks | None = None


def addresses_from_environment(environ: Mapping[str, str], special_args: Mapping[str, str]) -> LocalAddress:
    """Determine the addresses to advertise and to listen on (N18-N23, N26), and which networks may connect.

    Args:
        environ: environment variables; ROS_HOSTNAME, ROS_IP, ROS_IPV6, PYROS1_BIND, PYROS1_ALLOW and PYROS1_PORTS are
            used.
        special_args: special arguments from the command line, by key, which take precedence: ``__hostname``,
            ``__ip``, ``__bind``, ``__allow`` and ``__ports``.

    Raises:
        SettingError: the value of PYROS1_BIND, PYROS1_ALLOW or PYROS1_PORTS, or of the corresponding argument, is
            invalid. Ignoring it could admit peers that it was meant to exclude.
    """
    warnings = _environment_warnings(environ)
    ipv6 = environ.get("ROS_IPV6") == "on"
    host = (
        special_args.get("__hostname")
        or special_args.get("__ip")
        or environ.get("ROS_HOSTNAME")
        or environ.get("ROS_IP")
    )
    bind = "::" if ipv6 else "0.0.0.0"
    requested_bind = special_args.get("__bind") or environ.get("PYROS1_BIND")
    if requested_bind:
        bind = _parse_bind_address(requested_bind)
        if bind not in WILDCARD_ADDRESSES:
            host = host or bind  # the only address at which this process can be reached
    elif host:
        if host == "localhost" or host.startswith("127."):
            bind = "::1" if ipv6 and host == "localhost" else host if host[0] == "1" else "127.0.0.1"
        elif host == "::1":
            bind = "::1"
    ports = special_args.get("__ports") or environ.get("PYROS1_PORTS")
    allowed = special_args.get("__allow") or environ.get("PYROS1_ALLOW")
    return LocalAddress(
        host or _own_host(ipv6),
        bind,
        socket.AF_INET6 if ":" in bind else socket.AF_INET,
        warnings,
        _parse_port_range(ports) if ports else None,
        _parse_networks(allowed) if allowed else None,
    )


def _parse_port_range(text: str) -> PortRange:
    from pyros1.net.ports import parse_ports  # noqa: PLC0415 - rarely needed, and slows down the start of commands

    return parse_ports(text)


def _parse_networks(text: str) -> Networks:
    from pyros1.net.allowlist import Networks  # noqa: PLC0415

    return Networks(text)


def _parse_bind_address(text: str) -> str:
    addresses = direct_addresses(text)
    if addresses is None or not (addresses[0] in WILDCARD_ADDRESSES or is_own_address(addresses[0])):
        raise SettingError(
            f"PYROS1_BIND is {text[:60]!r}, which is not an address of this machine: its addresses are "
            f"{', '.join(interface_addresses())}; 0.0.0.0 means all"
        )
    return addresses[0]


def _environment_warnings(environ: Mapping[str, str]) -> list[str]:
    warnings = []
    for name in ("ROS_HOSTNAME", "ROS_IP"):
        value = environ.get(name)
        if value is None:
            continue
        if not value:
            warnings.append(f"invalid {name} (an empty string)")
        elif "://" in value:
            warnings.append(f"invalid {name} (protocol should not be included): {value}")
        elif name == "ROS_HOSTNAME" and re.search(r":[0-9]*\Z", value) and value.count(":") == 1:
            warnings.append(f"invalid {name} (port should not be included): {value}")
        elif name == "ROS_IP" and direct_addresses(value) is None:
            warnings.append(f"invalid {name} (not an IP address): {value}")
    return warnings


def _own_host(ipv6: bool) -> str:
    name = socket.gethostname()
    if name and name != "localhost" and not name.startswith("127."):
        return name
    for address in interface_addresses(ipv6):
        if not address.startswith("127.") and address != "::1":
            return address
    return "::1" if ipv6 else "127.0.0.1"


def interface_addresses(ipv6: bool = False) -> list[str]:
    """Return the addresses that the system reports for this machine's network interfaces.

    Args:
        ipv6: whether to return the IPv6 addresses of the host name in place of its IPv4 addresses.
    """
    from_interfaces: list[str] = []
    try:
        import fcntl  # noqa: PLC0415 - not on Windows
    except ImportError:
        fcntl = None  # type: ignore[assignment] # the usual way to mark a missing module
    if fcntl is not None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
            for _index, name in socket.if_nameindex():
                try:
                    # SIOCGIFADDR of Linux; the address is at byte 20 of struct ifreq
                    reply = fcntl.ioctl(sock.fileno(), 0x8915, struct.pack("256s", name.encode()[:15]))
                except OSError:
                    continue
                from_interfaces.append(socket.inet_ntoa(reply[20:24]))
    try:
        resolved = resolve_host(socket.gethostname())
    except OSError:
        resolved = []
    from_host_name = [address for address in resolved if (":" in address) == ipv6]
    return (
        from_host_name + [other for other in from_interfaces if other not in from_host_name]
        if not ipv6
        else from_host_name + from_interfaces
    )


def master_uri(environ: Mapping[str, str], special_args: Mapping[str, str]) -> str:
    """Return the master's URI (N25): ``__master:=``, else ROS_MASTER_URI, else ``http://localhost:11311``."""
    return special_args.get("__master") or environ.get("ROS_MASTER_URI") or DEFAULT_MASTER_URI


def parse_uri(uri: str, scheme: str = "http") -> tuple[str, int]:
    """Split ``scheme://host:port/`` into host (without brackets) and port.

    Raises:
        ProtocolError: the URI is malformed, or has no port (http defaults to 80).
    """
    match = _URI.match(uri)
    if match is None or match.group(1).lower() != scheme:
        raise ProtocolError(f"not a URI of the form {scheme}://host:port/: {uri[:200]!r}")
    host = match.group(2).strip("[]")
    port = int(match.group(3)[:10]) if match.group(3) else _DEFAULT_PORTS.get(scheme, 0)
    if not 0 < port < 65536:
        raise ProtocolError(f"the URI has no usable port: {uri[:200]!r}")
    return host, port


def make_uri(host: str, port: int, scheme: str = "http") -> str:
    """Return ``scheme://host:port/``, with brackets around an IPv6 address."""
    return f"{scheme}://[{host}]:{port}/" if ":" in host else f"{scheme}://{host}:{port}/"


def is_local(host: str) -> bool:
    """Return whether a host name or address belongs to this machine; may look up the name."""
    if host in ("localhost", "::1") or host.startswith("127.") or host == socket.gethostname():
        return True
    try:
        addresses = direct_addresses(host) or resolve_host(host)
    except OSError:
        return False
    return any(is_own_address(address) for address in addresses)


def is_own_address(address: str) -> bool:
    """Return whether an address belongs to this machine, which means that a socket can be bound to it."""
    if address.startswith("127.") or address == "::1":
        return True
    if address in ("0.0.0.0", "::"):
        return False
    try:
        with socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET, socket.SOCK_DGRAM) as sock:
            sock.bind((address, 0))
    except OSError:
        return False
    return True
