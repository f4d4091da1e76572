"""Shared code of ``ping`` and ``cleanup``: the timeout for a node, and error messages."""

from __future__ import annotations

from pyros1.ground.errors import DeadlineError, Error, UnknownHostError
from pyros1.net.hosts import parse_uri

PING_TIMEOUT = 3.0
"""Timeout for a node's response in seconds."""


def failure_reason(error: Error, name: str, uri: str) -> str:
    """Return the reason why a node did not respond, in the words of stock's tool."""
    cause = error.__cause__
    if isinstance(error, UnknownHostError):
        return f"Unknown host [{parse_uri(uri)[0]}] for node [{name}]"
    if isinstance(error, DeadlineError):
        return f"connection to [{uri}] timed out"
    if isinstance(cause, ConnectionRefusedError):
        return f"connection refused to [{uri}]"
    return f"communicating with [{uri}]: {error}"
