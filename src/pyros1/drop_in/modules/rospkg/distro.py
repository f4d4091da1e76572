"""The name of the ROS distribution."""

from __future__ import annotations

import os
from collections.abc import Mapping

from pyros1.drop_in.module_attributes import module_getattr
from rospkg.environment import get_etc_ros_dir

_REASON = "the descriptions of rosbuild's distributions are no longer online; `pip install rospkg` provides them"

__getattr__ = module_getattr(
    __name__, load_distro=_REASON, distro_uri=_REASON, Distro=_REASON, DistroStack=_REASON, Variant=_REASON
)


def current_distro_codename(env: Mapping[str, str] | None = None) -> str | None:
    """Return ROS_DISTRO, or the content of the file ``distro`` in ROS_ETC_DIR; None if neither exists."""
    environ = os.environ if env is None else env
    if "ROS_DISTRO" in environ:
        return environ["ROS_DISTRO"]
    path = os.path.join(get_etc_ros_dir(env=environ), "distro")
    if not os.path.isfile(path):
        return None
    with open(path, encoding="utf-8") as file:
        return file.read(1000).strip()
