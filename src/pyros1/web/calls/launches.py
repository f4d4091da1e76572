"""Calls that control running launches and describe their processes."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from pyros1.ground.errors import ParameterNotSetError
from pyros1.launch.running.control import Launch, launch_uris
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError
from pyros1.web.views.view import string_arg

_TIMEOUT = 3.0
_VERBS = ("stop", "start", "restart")
_MAX_TEXT_LENGTH = 20_000


def connect_to_launch(robot: Robot, args: Mapping[str, Any]) -> Launch:
    """Return a connection to a launch; the caller must close the connection. Args: launch (see `control`).

    Raises:
        RequestError: no launch with this name is registered.
    """
    param = string_arg(args, "launch")
    uri = launch_uris(robot.master).get(param)
    if uri is None:
        raise RequestError("this launch has ended")
    return Launch(uri, _TIMEOUT)


def control(robot: Robot, args: Mapping[str, Any]) -> None:
    """Tell a launch to stop, start or restart a process.

    Args: launch (the name of the parameter that the launch has set), process (its label), verb.
    """
    verb = string_arg(args, "verb")
    if verb not in _VERBS:
        raise RequestError(f"the verb must be one of {', '.join(_VERBS)}")
    launch = connect_to_launch(robot, args)
    try:
        launch.request(verb, string_arg(args, "process"))
    finally:
        launch.close()


def info(robot: Robot, args: Mapping[str, Any]) -> dict[str, str]:
    """Return the command line and working directory of a process. Args: launch, process (its label)."""
    launch = connect_to_launch(robot, args)
    try:
        process_info = launch.info(string_arg(args, "process"))
    finally:
        launch.close()
    arguments = process_info.get("args")
    arguments = [argument for argument in arguments if isinstance(argument, str)] if isinstance(arguments, list) else []
    return {
        "command": shlex.join(arguments)[:_MAX_TEXT_LENGTH],
        "cwd": str(process_info.get("cwd", ""))[:_MAX_TEXT_LENGTH],
    }


def forget(robot: Robot, args: Mapping[str, Any]) -> None:
    """Delete the parameter that a launch left behind when it was killed. Args: launch (the parameter's name)."""
    param = string_arg(args, "launch")
    if param not in launch_uris(robot.master):
        return
    with suppress(ParameterNotSetError):
        robot.master.delete_param(param)


CALLS: dict[str, Callable[[Robot, Mapping[str, Any]], Any]] = {
    "control": control,
    "info": info,
    "forget": forget,
}
CHANGES = frozenset({"control", "forget"})
