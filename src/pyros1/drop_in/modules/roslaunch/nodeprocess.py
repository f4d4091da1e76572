"""Defaults for the supervision of processes."""

from __future__ import annotations

from typing import Any

from pyros1.drop_in.module_attributes import module_getattr

DEFAULT_TIMEOUT_SIGINT = 15.0
DEFAULT_TIMEOUT_SIGTERM = 2.0
NUM_WORKERS = 3


__getattr__ = module_getattr(
    "roslaunch.nodeprocess",
    LocalProcess="use ROSLaunchRunner or scriptapi.ROSLaunch",
    create_master_process="use ROSLaunchRunner or scriptapi.ROSLaunch",
    create_node_process="use ROSLaunchRunner or scriptapi.ROSLaunch",
)
