"""Who may connect to this process: the machines that PYROS1_ALLOW names, and always this one.

ROS 1 knows no users and no passwords, so only the address can be checked. Other machines are refused right after
the connection was accepted, before a byte of theirs is read.
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
"""Maximum number of addresses that are remembered as reported."""
_RESET: Final = struct.pack("ii", 1, 0)
"""Value of SO_LINGER: closing sends a reset, and leaves nothing behind here."""
_KEYWORDS: Final = {"localhost": ("127.0.0.0/8", "::1/128")}

_Network = ipaddress.IPv4Network | ipaddress.IPv6Network
_Address = ipaddress.IPv4Address | ipaddress.IPv6Address


class Networks:
    """Some networks and addresses.

    Args:
        text: these, with commas or blanks between them, such as ``192.168.1.0/24, 10.0.0.7, fd00::/8``; ``localhost``
            for this machine alone.

    Raises:
        SettingError: the text names none, or something else.
    """

    def __init__(self, text: str) -> None:
        self.text = ", ".join(text.replace(",", " ").split())
        words = [part for word in self.text.split(", ") for part in _KEYWORDS.get(word, (word,))]
        if not self.text:
            raise SettingError("PYROS1_ALLOW is empty; localhost allows only this machine")
        self._networks = [_network(word) for word in words]

    def __str__(self) -> str:
        return self.text

    def __contains__(self, address: str) -> bool:
        found = _address(address)
        return found is not None and any(found in network for network in self._networks)


def _network(word: str) -> _Network:
    try:
        return ipaddress.ip_network(word)
    except ValueError:
        pass
    try:
        inside = ipaddress.ip_interface(word)
    except ValueError:
        raise SettingError(
            f"PYROS1_ALLOW: {word[:60]!r} is neither an address nor a network such as 192.168.1.0/24"
            " (host names are not supported)"
        ) from None
    raise SettingError(
        f"PYROS1_ALLOW: {word!r} is no network: use {inside.network} for the network, or {inside.ip} for the machine"
    )


def _address(text: str) -> _Address | None:
    try:
        address = ipaddress.ip_address(text.partition("%")[0])
    except ValueError:
        return None
    # A socket for both kinds reports an IPv4 peer like this.
    mapped = address.ipv4_mapped if isinstance(address, ipaddress.IPv6Address) else None
    return mapped or address


class Allowlist:
    """Admits the machines of some networks, and this one.

    Args:
        networks: the machines to admit.
        warn: gets a text about a refused peer, once for each address. It must not wait.
    """

    def __init__(self, networks: Networks, warn: Callable[[str], object]) -> None:
        self._networks = networks
        self._warn = warn
        self._reported: set[str] = set()

    def allows(self, peer: str, local_address: str) -> bool:
        """Return whether a peer may connect; if not, report it.

        Args:
            peer: its address.
            local_address: the address that it called. A connection from this machine to its own address comes from just
                that.
        """
        address = _address(peer)
        if address is not None and (
            address.is_loopback or address == _address(local_address) or peer in self._networks
        ):
            return True
        peer_text = str(address or peer)
        if peer_text not in self._reported:
            if len(self._reported) >= _MAX_REPORTED:
                self._reported.clear()
            self._reported.add(peer_text)
            self._warn(
                f"refused a connection from {peer_text}: PYROS1_ALLOW accepts only {self._networks}. "
                f"If it belongs to the robot: PYROS1_ALLOW='{self._networks}, {peer_text}', and start this again"
            )
        return False

    def admits(self, sock: socket.socket, peer: Any) -> bool:
        """Return whether a connection that was just accepted may stay; if not, it is closed.

        Args:
            sock: the connection.
            peer: its address, as ``accept`` returns it.
        """
        try:
            if self.allows(str(peer[0]), str(sock.getsockname()[0])):
                return True
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RESET)
        except OSError:
            pass  # it is closed already
        sock.close()
        return False


def make_allowlist(networks: Networks | None) -> Allowlist | None:
    """Return a check that admits peers of some networks and reports others on stderr; None if all may connect."""
    if networks is None:
        return None
    terminal = BackgroundWriter("allowlist: warnings", write_to_terminal)
    return Allowlist(networks, lambda text: terminal.write("stderr", f"WARNING: {text}\n"))
