"""``rospy status``."""

from __future__ import annotations

import os
import sys
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print which rospy the programs of this environment import."""
    if args:
        raise UsageError("status takes no arguments")
    from pyros1.drop_in.environment import installed_rospy, is_enabled, pth_file  # noqa: PLC0415
    from pyros1.drop_in.finder import MODULES, VARIABLE  # noqa: PLC0415

    found = installed_rospy()
    print(f"Python:  {sys.executable}")
    if found is None:
        print(
            "rospy:   none; only programs that pyros1 starts find it. `pyros1 rospy enable` makes it available to all."
        )
    elif found.startswith(MODULES):
        print(f"rospy:   pyros1's, {os.path.dirname(found)}")
    else:
        print(f"rospy:   a real one, {os.path.dirname(found)}, which takes precedence. {VARIABLE}=pyros1 selects ours.")
    print(f"enabled: {f'yes, by {pth_file()}' if is_enabled() else 'no'}")
    for name in (VARIABLE, "PYTHONPATH"):
        if os.environ.get(name):
            print(f"{name}={os.environ[name]}")


VERB = Verb("status", "show which rospy is used here", examples=[("", "this environment")], stock="", run=run)
