"""The ROS master: registry, parameter server, their XML-RPC API, notification of nodes."""

from __future__ import annotations

from pyros1.master.server import Master

__all__ = ["Master"]
