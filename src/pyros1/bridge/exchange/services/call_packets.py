"""The parts that both ends of a service call share: sending packets, and counters. No I/O."""

from __future__ import annotations

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.calls import CallHead, encode_call_head
from pyros1.bridge.protocol.key_expressions import call_key
from pyros1.bridge.rules.rules import Priority

SMALL = 16 << 10
"""Maximum size in bytes of a body that is sent before images; larger ones are sent as fast as the network allows."""
_MAX_WAIT = 8.0
"""Maximum seconds that a small packet waits to be sent, and maximum seconds until it is repeated."""
_SLOWEST = 500_000
"""Speed in bytes per second of the slowest network that still gets large packets through in time."""
_MAX_ERROR = 10_000


class CallCounts:
    """Counts a service's calls and failed calls, and keeps the text of the last error."""

    def __init__(self) -> None:
        self.calls = 0
        self.errors = 0
        self.last_error = ""

    def fail(self, body: bytes) -> None:
        """Count a failed call."""
        self.errors += 1
        self.last_error = body.decode("utf-8", "replace")[:300]


def encode_error(text: str) -> bytes:
    """Return the text of an error as the body of a reply."""
    return text.encode("utf-8", "replace")[:_MAX_ERROR]


def repeat_period(size: int, repeats: int) -> float:
    """Return after how many seconds to resend a packet that the other site has not acknowledged.

    Args:
        size: size of its body in bytes.
        repeats: how often it has already been resent.
    """
    return float(min(_MAX_WAIT, 2**repeats)) + size / _SLOWEST


def max_transit_time(size: int) -> float:
    """Return the maximum number of seconds that a packet with a body of this size may be in transit; a later one may be
    obsolete.
    """
    return 2 * (_MAX_WAIT + size / _SLOWEST)


def send(peer: str, service: SharedName, head: CallHead, body: bytes, expires: float) -> Send:
    """Return the action that sends a packet of a call.

    Args:
        peer: the other site.
        service: the service.
        head, body: the packet.
        expires: time by the site's clock after which it is useless.
    """
    priority = Priority.HIGH if len(body) <= SMALL else Priority.NORMAL
    # A packet that is still waiting is not queued twice.
    return Send(call_key(peer, service), encode_call_head(head), body, priority, head.number, False, expires)
