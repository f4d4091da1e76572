"""``pyros1 msg``: shows message types, like rosmsg (L86-L89)."""

from __future__ import annotations

from pyros1.cli.records import Command

COMMAND = Command(
    "msg",
    "show message types",
    group="develop",
    stock="rosmsg",
    heading="{program} is a command-line tool for displaying information about ROS Message types.\n\nCommands:",
    order=("show",),
    row="\t{program} {name}\t{about}",
    footer="\nType {program} <command> -h for more detailed usage\n",
    stock_help=("", "--help"),
)
