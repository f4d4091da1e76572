"""``pyros1 log``: gets and sets log levels, and prints log messages, like rosconsole (L176)."""

from __future__ import annotations

from pyros1.cli.records import Command

COMMAND = Command(
    "log",
    "get and set log levels, print log messages",
    group="inspect",
    stock="rosconsole",
    heading="{program} is a command-line tool for configuring the logger level of ROS nodes.\n\nCommands:",
    order=("get", "list", "set", "echo"),
    row="\t{program} {name}\t{about}",
    footer="\nType {program} <command> -h for more detailed usage, e.g. '{program} list -h'\n",
)
