"""``pyros1 param``: gets and sets parameters, like rosparam (L80-L85)."""

from __future__ import annotations

from pyros1.cli.records import Command

COMMAND = Command(
    "param",
    "get and set parameters",
    group="inspect",
    stock="rosparam",
    heading="{program} is a command-line tool for getting, setting, and deleting parameters from the ROS Parameter "
    "Server.\n\nCommands:",
    order=("set", "get", "load", "dump", "delete", "list"),
    row="\t{program} {name}\t{about}",
    footer="",
    usage_exit_code=0,
)
