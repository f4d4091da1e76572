"""Finds the program that replaces a nodelet (no I/O). See https://wiki.ros.org/nodelet."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence

from pyros1.ground.errors import Error, PackageNotFoundError
from pyros1.ground.terminal_text import one_line

OPERANDS: Mapping[str, tuple[str, ...]] = {
    "manager": (),
    "load": ("pkg/Type", "manager"),
    "standalone": ("pkg/Type",),
    "unload": ("name", "manager"),
}
"""The commands of the program ``nodelet``, and the arguments that each requires."""
_OTHER_NAMES = {
    "RobotLocalization/EkfNodelet": ("robot_localization", "ekf_localization_node"),
    "RobotLocalization/UkfNodelet": ("robot_localization", "ukf_localization_node"),
    "RobotLocalization/NavSatTransformNodelet": ("robot_localization", "navsat_transform_node"),
}
"""Classes whose names differ from those of their package or program: class -> (package, program)."""
_KIND = re.compile(r"(?:nodelet|node|\.py)*\Z")


def package_of(class_name: str) -> str:
    """Return the package of a nodelet's class: ``image_proc`` for ``image_proc/rectify``; empty if it names none."""
    if class_name in _OTHER_NAMES:
        return _OTHER_NAMES[class_name][0]
    return re.split("/|::", class_name, maxsplit=1)[0] if re.search("/|::", class_name) else ""


def is_throttle(class_name: str) -> bool:
    """Return whether a class uses nodelet_topic_tools' NodeletThrottle, by its name: ``NodeletThrottleImage``."""
    return re.split("/|::", class_name)[-1].startswith("NodeletThrottle")


def find_program(class_name: str, programs: Iterable[str]) -> str:
    """Return the program that replaces a nodelet; empty if there is none.

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
    wanted = _normalized(re.split("/|::", class_name)[-1])
    return next((name for name in names if _normalized(name) == wanted), "")


class NodeletError(Error):
    """No program replaces a nodelet, or the arguments of ``nodelet`` are invalid."""


def locate_nodelet(class_name: str, executables: Callable[[str], Iterable[str]]) -> tuple[str, str]:
    """Return the program that replaces a nodelet, with its package.

    Args:
        class_name: the nodelet's class.
        executables: returns the names of a package's programs, or raises PackageNotFoundError.

    Raises:
        NodeletError: there is no such program.
    """
    shown, package = one_line(class_name, 100), package_of(class_name)
    if not package:
        raise NodeletError(f"{shown!r} is not the class of a nodelet, such as image_proc/rectify")
    hint = "run a node with the same topics in its place, or this nodelet with stock ROS"
    try:
        program = find_program(class_name, executables(package))
    except PackageNotFoundError:
        raise NodeletError(f"no package {one_line(package, 100)} for the nodelet {shown}: {hint}") from None
    if not program:
        raise NodeletError(f"pyros1 has no node that replaces the nodelet {shown}: {hint}")
    return package, program


def check_arguments(words: Sequence[str]) -> None:
    """Check the arguments of the program ``nodelet``, without remappings and ``--no-bond``.

    Raises:
        NodeletError: there are too few arguments, or the first is not a command.
    """
    verb = words[0] if words else ""
    operands = OPERANDS.get(verb)
    if operands is None:
        found = f"not {one_line(repr(verb), 50)}" if verb else "but there is none"
        raise NodeletError(f"the first argument must be manager, load, standalone or unload, {found}")
    if len(words) <= len(operands):
        raise NodeletError(f"too few arguments: {' '.join((verb, *operands))} is expected")


def _normalized(name: str) -> str:
    return _KIND.sub("", name.lower().replace("_", ""), count=1) or name
