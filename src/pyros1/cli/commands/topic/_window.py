"""What ``hz``, ``bw`` and ``delay`` share. Messages are decoded only for a filter or a stamp."""

from __future__ import annotations

from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.records import Flag, Option

PERIOD = 1.0
"""Seconds between two lines of output."""
WINDOW = Option(
    "-w",
    "--window",
    dest="window_size",
    metavar="WINDOW",
    help="window size, in # of messages, for calculating rate",
)
TCPNODELAY = Flag("--tcpnodelay", help="use the TCP_NODELAY transport hint when subscribing to topics")


def window(options: Any) -> int:
    """Return the window size in messages, -1 if none was given."""
    if options.window_size is None:
        return -1
    try:
        size = int(options.window_size)
    except ValueError:
        raise UsageError("window size must be an integer") from None
    return size if size > 0 else -1
