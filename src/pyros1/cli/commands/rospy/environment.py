"""``rospy enable``, ``disable`` and ``status``: control whether this Python environment finds the ROS modules."""

from __future__ import annotations

import os
import sys
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb


def _enable(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Write the file that makes the modules available, and print whether programs can now import rospy."""
    if args:
        raise UsageError("enable takes no arguments")
    from pyros1.drop_in.environment import enable, installed_rospy  # noqa: PLC0415
    from pyros1.drop_in.finder import MODULES_FOLDER, PREFERENCE_VARIABLE  # noqa: PLC0415

    file, errors = enable()
    for error in errors:
        print(f"WARNING: no stubs for editors: {error}", file=sys.stderr)
    print(f"wrote {file}")
    rospy_file = installed_rospy()
    if rospy_file is None and os.environ.get(PREFERENCE_VARIABLE):
        print(
            f"programs still do not import rospy: {PREFERENCE_VARIABLE}={os.environ[PREFERENCE_VARIABLE]} is in the "
            "environment"
        )
    elif rospy_file is None:
        print("programs of this environment still cannot import rospy: can its Python start?")
    elif not rospy_file.startswith(MODULES_FOLDER):
        print(
            f"a real rospy is installed and takes precedence: {rospy_file}. Set {PREFERENCE_VARIABLE}=pyros1 to use "
            "pyros1's rospy."
        )
    else:
        print("programs of this environment can now import rospy, std_msgs.msg and the other modules of ROS 1")


def _disable(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Remove the file that makes the modules available."""
    if args:
        raise UsageError("disable takes no arguments")
    from pyros1.drop_in.environment import disable, pth_file  # noqa: PLC0415

    print(f"removed {pth_file()}" if disable() else "rospy was not enabled")


def _status(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print which rospy the programs of this environment import."""
    if args:
        raise UsageError("status takes no arguments")
    from pyros1.drop_in.environment import installed_rospy, is_enabled, pth_file  # noqa: PLC0415
    from pyros1.drop_in.finder import MODULES_FOLDER, PREFERENCE_VARIABLE  # noqa: PLC0415

    rospy_file = installed_rospy()
    print(f"Python:  {sys.executable}")
    if rospy_file is None:
        print(
            "rospy:   none; only programs started by pyros1 find its rospy. `pyros1 rospy enable` enables it for all."
        )
    elif rospy_file.startswith(MODULES_FOLDER):
        print(f"rospy:   pyros1's, {os.path.dirname(rospy_file)}")
    else:
        print(
            f"rospy:   a real one, {os.path.dirname(rospy_file)}, which takes precedence. "
            f"{PREFERENCE_VARIABLE}=pyros1 selects pyros1's rospy."
        )
    print(f"enabled: {f'yes, by {pth_file()}' if is_enabled() else 'no'}")
    for name in (PREFERENCE_VARIABLE, "PYTHONPATH"):
        if os.environ.get(name):
            print(f"{name}={os.environ[name]}")


VERBS = [
    Verb(
        "enable",
        "let all programs of this Python environment import rospy, std_msgs.msg, ...",
        description="Writes a .pth file to the environment's site-packages, so that all programs find rospy and the "
        "other ROS modules. Without this file, only programs that pyros1 starts, and programs in a shell after "
        "`source <(pyros1 setup)`, find them. Also writes stubs of all message packages, for type checkers and for "
        "completion in editors. Run this command again after adding message packages.",
        examples=[("", "let `python my_node.py`, pytest, notebooks and editors find rospy")],
        stock="",
        run=_enable,
    ),
    Verb(
        "disable",
        "undo `rospy enable`: let only programs that pyros1 starts import rospy, std_msgs.msg, ...",
        examples=[("", "remove the .pth file that `rospy enable` wrote")],
        stock="",
        run=_disable,
    ),
    Verb(
        "status",
        "print which rospy the programs of this Python environment import",
        examples=[("", "print which rospy is imported, and the settings that matter")],
        stock="",
        run=_status,
    ),
]
