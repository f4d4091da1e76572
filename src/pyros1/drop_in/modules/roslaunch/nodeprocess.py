"""Numbers about processes."""

from __future__ import annotations

from typing import Any

DEFAULT_TIMEOUT_SIGINT = 15.0
DEFAULT_TIMEOUT_SIGTERM = 2.0
NUM_WORKERS = 3


def __getattr__(name: str) -> Any:
    if name in ("LocalProcess", "create_master_process", "create_node_process"):
        raise AttributeError(f"pyros1 has no roslaunch.nodeprocess.{name}: use ROSLaunchRunner or scriptapi.ROSLaunch")
    raise AttributeError(f"module 'roslaunch.nodeprocess' has no attribute {name!r}")
