"""Finds rclpy's message and service classes by name, including those of the user's own packages.

The names come from other programs, and importing a module runs it, so a package is only imported if its ``share``
folder has a definition of the type.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

from pyros1.ground.errors import UnknownTypeError
from pyros1.ros2_types.rclpy_packages import RclpyPackages

_ACTION_SERVICES = {"_SendGoal": "SendGoalService", "_GetResult": "GetResultService"}
_ACTION_MESSAGES = {"_FeedbackMessage": "FeedbackMessage"}


class TypeClasses:
    """The classes of messages and services.

    Args:
        types: the installed types.
    """

    def __init__(self, types: RclpyPackages) -> None:
        self.types = types
        self._found: dict[str, Any] = {}

    def message(self, name: str) -> Any:
        """Return the class of a message.

        Args:
            name: for example ``std_msgs/msg/String`` or ``example_interfaces/action/Fibonacci_FeedbackMessage``.

        Raises:
            UnknownTypeError: its package is not installed, or cannot be imported.
        """
        return self._get(name, "msg", _ACTION_MESSAGES)

    def service(self, name: str) -> Any:
        """Return the class of a service.

        Args:
            name: for example ``std_srvs/srv/SetBool`` or ``example_interfaces/action/Fibonacci_SendGoal``.

        Raises:
            UnknownTypeError: as for `message`.
        """
        return self._get(name, "srv", _ACTION_SERVICES)

    def _get(self, name: str, own_kind: str, of_actions: dict[str, str]) -> Any:
        if name not in self._found:
            if problem := self.types.problem(name):
                raise UnknownTypeError(problem)
            package, kind, short = name.split("/")
            part = next((part for part in of_actions if kind == "action" and short.endswith(part)), "")
            if kind != own_kind and not part:
                raise UnknownTypeError(f"{name} is not a {'message' if own_kind == 'msg' else 'service'} type")
            try:
                found = getattr(import_module(f"{package}.{kind}"), short.removesuffix(part))
                self._found[name] = getattr(found.Impl, of_actions[part]) if part else found
            except (ImportError, AttributeError) as error:
                raise UnknownTypeError(f"rclpy cannot use {name}: {error}") from error
        return self._found[name]
