"""Reads ``<machine>`` tags (https://wiki.ros.org/roslaunch/XML/machine)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pyros1.ground.errors import LaunchError
from pyros1.launch.plan import MachinePlan, Plan
from pyros1.launch.reading.document import Element

SETTING_NAMES = ("env-loader", "ssh-port", "user", "password", "default", "timeout")
_DEFAULT_PORT = 22
_DEFAULT_TIMEOUT = 10.0


def read_machine(element: Element, attribute: Callable[[str], str | None], plan: Plan) -> str | None:
    """Add the machine that a ``<machine>`` tag declares to the plan.

    Args:
        element: the ``<machine>`` element.
        attribute: returns an attribute's value, or None if the element does not have it.
        plan: the plan to add to.

    Returns:
        The machine's name if it becomes the default machine, else None.

    Raises:
        LaunchError: an attribute is missing or invalid, or the name is already declared with other attributes (X68).
    """
    name, address = attribute("name"), attribute("address")
    # An empty address is an error only if a node is to run there, since existing files use it as a default.
    if not name or address is None:
        raise LaunchError(f"<machine> tag is missing required attribute: '{'address' if name else 'name'}'")
    for key, value in element.attributes.items():
        if key.startswith("ros-") and value:
            raise LaunchError(f"<machine> tag cannot have a '{key}' attribute; use 'env-loader' instead")
    if any(child.tag == "env" for child in element.children):
        raise LaunchError("<machine> tag cannot have an <env> tag in it; use 'env-loader' instead")
    settings = {key: attribute(key) or "" for key in SETTING_NAMES if key in element.attributes}
    machine = MachinePlan(name, address, tuple(settings.items()))
    comparable = _comparable_settings(machine)
    if _comparable_settings(plan.machines.setdefault(machine.name, machine)) != comparable:
        raise LaunchError(f"machine [{name}] has already been declared with other attributes")
    return name if settings.get("default", "").lower() == "true" else None


def _comparable_settings(machine: MachinePlan) -> tuple[Any, ...]:
    """Return a machine's address and settings in a form in which equal settings compare equal.

    Raises:
        LaunchError: a setting is invalid.
    """
    settings = dict(machine.settings)
    default = settings.get("default", "").lower() or "false"
    if default not in ("true", "false", "never"):
        raise LaunchError(f"machine default must be true, false or never, not {default!r}")
    try:
        port = int(settings.get("ssh-port") or _DEFAULT_PORT)
    except ValueError as error:
        raise LaunchError(f"'ssh-port' must be a number: [{settings['ssh-port']}]") from error
    try:
        timeout = float(settings.get("timeout", _DEFAULT_TIMEOUT))
    except ValueError as error:
        raise LaunchError(f"'timeout' must be a number: [{settings['timeout']}]") from error
    if not timeout > 0:
        raise LaunchError(f"'timeout' must be a positive number: [{settings['timeout']}]")
    texts = (settings.get(key, "") for key in ("env-loader", "user", "password"))
    return (machine.address, port, timeout, default == "never", *texts)
