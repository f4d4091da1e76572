"""``rospy enable``."""

from __future__ import annotations

import os
import sys
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Write the file that offers the modules."""
    if args:
        raise UsageError("enable takes no arguments")
    from pyros1.drop_in.environment import enable, installed_rospy  # noqa: PLC0415
    from pyros1.drop_in.finder import MODULES, VARIABLE  # noqa: PLC0415

    file, errors = enable()
    for error in errors:
        print(f"WARNING: no stubs: {error}", file=sys.stderr)
    print(f"wrote {file}")
    found = installed_rospy()
    if found is None and os.environ.get(VARIABLE):
        print(f"programs still do not import rospy: {VARIABLE}={os.environ[VARIABLE]} is in the environment")
    elif found is None:
        print("programs of this environment still cannot import rospy: does its Python start?")
    elif not found.startswith(MODULES):
        print(f"a real rospy is installed and takes precedence: {found}. Set {VARIABLE}=pyros1 to use ours.")
    else:
        print("programs of this environment can now import rospy, std_msgs.msg and the other modules of ROS 1")


VERB = Verb(
    "enable",
    "let all programs of this Python environment import rospy, std_msgs.msg, ...",
    description="Writes a .pth file into the environment's site-packages, and stubs for type checkers and the "
    "completion of editors (for new message packages, do it again). Without it, only programs that pyros1 starts find "
    "the modules, and those of a shell after `source <(pyros1 setup)`.",
    examples=[("", "then `python my_node.py`, pytest, notebooks and editors find rospy")],
    stock="",
    run=run,
)
