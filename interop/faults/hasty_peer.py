"""The pyros1 peer, with keep-alive in seconds instead of minutes: so tests need not wait."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "peers"))

import pyros1_peer

from pyros1.net import keepalive
from pyros1.node.publishing import tcp_link

if __name__ == "__main__":
    keepalive.PROBE_IDLE_TIME, keepalive.PROBE_INTERVAL, keepalive.MAX_PROBES, tcp_link.PEER_CHECK_INTERVAL = (
        1,
        1,
        2,
        0.5,
    )  # type: ignore[misc]
    sys.exit(pyros1_peer.main())
