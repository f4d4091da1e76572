"""The ROS master: the registry and the parameter server, their XML-RPC API, and notifications to nodes."""

from __future__ import annotations

from pyros1.master.server import Master

__all__ = ["Master"]
