"""Which program of a package does what a nodelet does (no I/O)."""

from __future__ import annotations

import re
from collections.abc import Iterable

_OTHER_NAMES = {
    "RobotLocalization/EkfNodelet": ("robot_localization", "ekf_localization_node"),
    "RobotLocalization/UkfNodelet": ("robot_localization", "ukf_localization_node"),
    "RobotLocalization/NavSatTransformNodelet": ("robot_localization", "navsat_transform_node"),
}
"""Classes whose packages or programs are named otherwise: class -> package and program."""
_KIND = re.compile(r"(?:nodelet|node|\.py)*\Z")


def package_of(class_name: str) -> str:
    """Return the package of a nodelet's class: ``image_proc`` for ``image_proc/rectify``; empty if it names none."""
    if class_name in _OTHER_NAMES:
        return _OTHER_NAMES[class_name][0]
    return re.split("/|::", class_name, maxsplit=1)[0] if re.search("/|::", class_name) else ""


def is_throttle(class_name: str) -> bool:
    """Return whether a class is made of nodelet_topic_tools' NodeletThrottle, by its name: ``NodeletThrottleImage``."""
    return re.split("/|::", class_name)[-1].startswith("NodeletThrottle")


def find_program(class_name: str, programs: Iterable[str]) -> str:
    """Return the program that does what a nodelet does; empty if there is none.

    It is the one with the same name, apart from upper case, underscores, and ``nodelet`` or ``node`` at the end:
    ``depthimage_to_laserscan`` for ``depthimage_to_laserscan/DepthImageToLaserScanNodelet``.

    Args:
        class_name: the nodelet's class.
        programs: the names of the programs in its package.
    """
    names = sorted(programs, key=lambda name: (len(name), name))
    if class_name in _OTHER_NAMES:
        program = _OTHER_NAMES[class_name][1]
        return program if program in names else ""
    wanted = _plain(re.split("/|::", class_name)[-1])
    return next((name for name in names if _plain(name) == wanted), "")


def _plain(name: str) -> str:
    return _KIND.sub("", name.lower().replace("_", ""), count=1) or name
