"""Shared code of ``ping`` and ``cleanup``: the timeout for a response, and the reason why a node did not respond."""

from __future__ import annotations

from pyros1.ground.errors import DeadlineError, Error, UnknownHostError
from pyros1.net.hosts import parse_uri

PING_TIMEOUT = 3.0
"""Timeout for a node's response in seconds."""


def failure_reason(error: Error, node_name: str, uri: str) -> str:
    """Return the reason why a node did not respond, in the words of the stock tool."""
    cause = error.__cause__
    if isinstance(error, UnknownHostError):
        return f"Unknown host [{parse_uri(uri)[0]}] for node [{node_name}]"
    if isinstance(error, DeadlineError):
        return f"connection to [{uri}] timed out"
    if isinstance(cause, ConnectionRefusedError):
        return f"connection refused to [{uri}]"
    return f"communicating with [{uri}]: {error}"
