"""The ROS distribution of this machine."""

from __future__ import annotations

import os
from collections.abc import Mapping

from pyros1.drop_in.missing import missing

__getattr__ = missing(__name__)


def current_distro_codename(env: Mapping[str, str] | None = None) -> str | None:
    """Return ROS_DISTRO; None if it is not set."""
    return (os.environ if env is None else env).get("ROS_DISTRO")
