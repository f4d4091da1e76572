"""Prints and returns the arguments of launch files."""

from __future__ import annotations

import sys
from typing import Any

from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.system_resources import make_resources
from roslaunch.core import RLException, rl_errors


def dump_args(roslaunch_files: Any) -> None:
    """Print the arguments of launch files; exit with code 1 if a file cannot be read."""
    try:
        args = get_args(roslaunch_files)
    except RLException as error:
        print(str(error), file=sys.stderr)
        sys.exit(1)
    for title, optional in ("Required Arguments:", False), ("Optional Arguments:", True):
        names = sorted(name for name, (_, default) in args.items() if bool(default) is optional)
        if names:
            print(title)
        for name in names:
            doc, default = args[name]
            default_text = f' (default "{default}")' if optional else ""
            print(f"  {name}{default_text}: {doc or 'undocumented'}")
    if not args:
        print("No arguments.")


@rl_errors
def get_args(roslaunch_files: Any) -> dict[str, tuple[str | None, str | None]]:
    """Return (documentation, default) of each argument, by name; either may be None.

    Raises:
        RLException: a file cannot be read.
    """
    plan = load_plan(list(roslaunch_files), {}, make_resources(), only_args=True)
    return {arg.name: (arg.doc, arg.default) for arg in plan.args.values()}
