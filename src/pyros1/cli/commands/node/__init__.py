"""``pyros1 node``: lists, inspects and stops nodes, like rosnode (L70-L75)."""

from __future__ import annotations

from pyros1.cli.records import Command

COMMAND = Command(
    "node",
    "list, inspect and stop nodes",
    group="inspect",
    stock="rosnode",
    heading="{program} is a command-line tool for printing information about ROS Nodes.\n\nCommands:",
    order=("ping", "list", "info", "machine", "kill", "cleanup", "tree", "status", "stop", "start", "restart"),
    row="\t{program} {name}\t{about}",
    footer="\nType {program} <command> -h for more detailed usage, e.g. '{program} ping -h'\n",
    stock_help=["--help"],
)
