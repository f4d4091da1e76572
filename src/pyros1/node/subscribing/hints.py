"""Transport hints of a subscriber."""

from __future__ import annotations

from typing import NamedTuple

DEFAULT_TRANSPORTS = ("local", "tcp")


class Hints(NamedTuple):
    """Transport hints of a subscriber (roscpp's TransportHints, C11).

    Attributes:
        tcp_nodelay: whether to ask publishers to send small messages without delay.
        transports: "local", "tcp" and "udp", in order of preference; "local" requires "tcp".
        max_datagram_size: maximum size of a datagram in bytes, for "udp".
        low_latency: whether to poll for the next message for a while before sleeping; see `TcpSource.low_latency`.
    """

    tcp_nodelay: bool = True
    transports: tuple[str, ...] = DEFAULT_TRANSPORTS
    max_datagram_size: int = 1500
    low_latency: bool = False

    def check(self) -> None:
        """Check that the hints are valid.

        Raises:
            ValueError: a transport is unknown, or the size is out of range.
            TypeError: the size is not an integer.
        """
        if not hasattr(type(self.max_datagram_size), "__index__"):
            raise TypeError(f"max_datagram_size must be a whole number of bytes, not {self.max_datagram_size!r:.80}")
        if self.transports in (DEFAULT_TRANSPORTS, ("tcp",)):
            return
        from pyros1.wire.datagram import MAX_DATAGRAM_SIZE, MIN_DATAGRAM_SIZE  # noqa: PLC0415 - few nodes need it

        if not self.transports or not set(self.transports) <= {"local", "tcp", "udp"}:
            raise ValueError(f"transports must be some of 'local', 'tcp' and 'udp', not {self.transports!r}")
        if "local" in self.transports and "tcp" not in self.transports:
            raise ValueError("transports: 'local' is only for publishers on this machine; add 'tcp' for the others")
        if not MIN_DATAGRAM_SIZE <= self.max_datagram_size <= MAX_DATAGRAM_SIZE:
            sizes = f"{MIN_DATAGRAM_SIZE} to {MAX_DATAGRAM_SIZE}"
            raise ValueError(f"max_datagram_size must be {sizes}, not {self.max_datagram_size}")
