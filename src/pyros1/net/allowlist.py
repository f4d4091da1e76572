"""Restricts which machines may connect to this process: those listed in PYROS1_ALLOW, and always this machine.

ROS 1 has no users or passwords, so only the address can be checked. A connection from any other machine is closed as
soon as it is accepted, before anything is read from it.
"""

from __future__ import annotations

import ipaddress
import socket
import struct
from collections.abc import Callable
from typing import Any, Final

from pyros1.ground.errors import SettingError
from pyros1.net.background_writer import BackgroundWriter, write_to_terminal

_MAX_REPORTED: Final = 1000
"""Maximum number of refused addresses to remember; each is reported only once."""
_LINGER_RESET: Final = struct.pack("ii", 1, 0)
"""Value of SO_LINGER: closing sends a reset, so no socket stays in TIME_WAIT on this side."""
_KEYWORDS: Final = {"localhost": ("127.0.0.0/8", "::1/128")}

_Network = ipaddress.IPv4Network | ipaddress.IPv6Network
_Address = ipaddress.IPv4Address | ipaddress.IPv6Address


class Networks:
    """A set of networks and addresses.

    Args:
        text: networks and addresses, separated by commas or blanks, such as ``192.168.1.0/24, 10.0.0.7, fd00::/8``;
            ``localhost`` is this machine.

    Raises:
        SettingError: the text is empty, or an entry is not a network or an address.
    """

    def __init__(self, text: str) -> None:
        self.text = ", ".join(text.replace(",", " ").split())
        entries = [part for entry in self.text.split(", ") for part in _KEYWORDS.get(entry, (entry,))]
        if not self.text:
            raise SettingError("PYROS1_ALLOW is empty; localhost allows only this machine")
        self._networks = [_parse_network(entry) for entry in entries]

    def __str__(self) -> str:
        return self.text

    def __contains__(self, address: str) -> bool:
        parsed = _parse_address(address)
        return parsed is not None and any(parsed in network for network in self._networks)


def _parse_network(entry: str) -> _Network:
    try:
        return ipaddress.ip_network(entry)
    except ValueError:
        pass
    try:
        interface = ipaddress.ip_interface(entry)
    except ValueError:
        raise SettingError(
            f"PYROS1_ALLOW: {entry[:60]!r} is neither an address nor a network such as 192.168.1.0/24"
            " (host names are not supported)"
        ) from None
    raise SettingError(
        f"PYROS1_ALLOW: {entry!r} is not a network: use {interface.network} for the network, "
        f"or {interface.ip} for the machine"
    )


def _parse_address(text: str) -> _Address | None:
    try:
        address = ipaddress.ip_address(text.partition("%")[0])
    except ValueError:
        return None
    # A dual-stack socket reports an IPv4 peer as an IPv4-mapped IPv6 address.
    ipv4_address = address.ipv4_mapped if isinstance(address, ipaddress.IPv6Address) else None
    return ipv4_address or address


class Allowlist:
    """Admits connections from the given networks and from this machine.

    Args:
        networks: the networks from which to admit connections.
        warn: called with a message about a refused peer, once for each address. It must not block.
    """

    def __init__(self, networks: Networks, warn: Callable[[str], object]) -> None:
        self._networks = networks
        self._warn = warn
        self._reported_addresses: set[str] = set()

    def admit_address(self, peer_address: str, local_address: str) -> bool:
        """Return whether a peer may connect; if not, report its address the first time.

        Args:
            peer_address: the peer's address.
            local_address: the local address of the connection. If the peer has the same address, it is on this machine.
        """
        address = _parse_address(peer_address)
        if address is not None and (
            address.is_loopback or address == _parse_address(local_address) or peer_address in self._networks
        ):
            return True
        peer_text = str(address or peer_address)
        if peer_text not in self._reported_addresses:
            if len(self._reported_addresses) >= _MAX_REPORTED:
                self._reported_addresses.clear()
            self._reported_addresses.add(peer_text)
            self._warn(
                f"refused a connection from {peer_text}: PYROS1_ALLOW accepts only {self._networks}. "
                f"If it belongs to the robot, set PYROS1_ALLOW='{self._networks}, {peer_text}' and restart this program"
            )
        return False

    def admit(self, sock: socket.socket, peer_address: Any) -> bool:
        """Return whether a connection that was just accepted may stay open; if not, close it.

        Args:
            sock: the connection.
            peer_address: the peer's address, as returned by ``accept``.
        """
        try:
            if self.admit_address(str(peer_address[0]), str(sock.getsockname()[0])):
                return True
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _LINGER_RESET)
        except OSError:
            pass  # the peer has closed the connection already
        sock.close()
        return False


def make_allowlist(networks: Networks | None) -> Allowlist | None:
    """Return an Allowlist that reports refused peers on stderr; None if ``networks`` is None."""
    if networks is None:
        return None
    terminal_writer = BackgroundWriter("allowlist: warnings", write_to_terminal)
    return Allowlist(networks, lambda text: terminal_writer.write("stderr", f"WARNING: {text}\n"))
