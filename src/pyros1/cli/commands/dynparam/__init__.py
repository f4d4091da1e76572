"""``pyros1 dynparam``: configures nodes, like the stock tool (L200, https://wiki.ros.org/dynamic_reconfigure)."""

from __future__ import annotations

from pyros1.cli.records import Command

COMMAND = Command(
    "dynparam",
    "show and change parameters of running nodes",
    group="inspect",
    stock="dynparam",
    heading="{program} shows and changes the parameters of nodes that use dynamic_reconfigure.\n\nCommands:",
    order=("list", "get", "set", "set_from_parameters", "load", "dump"),
    row="\t{program} {name}\t{about}",
    footer="\nType {program} <command> -h for more detailed usage, e.g. '{program} get -h'\n",
    usage_exit_code=1,
)
