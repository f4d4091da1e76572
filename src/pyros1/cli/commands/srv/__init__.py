"""``pyros1 srv``: shows service types, like rossrv. It has the same verbs as ``pyros1 msg`` (L86-L89)."""

from __future__ import annotations

from pyros1.cli.records import Command

COMMAND = Command(
    "srv",
    "show service types",
    group="develop",
    stock="rossrv",
    heading="{program} is a command-line tool for displaying information about ROS Service types.\n\nCommands:",
    order=("show",),
    row="\t{program} {name}\t{about}",
    footer="\nType {program} <command> -h for more detailed usage\n",
    stock_help=("", "--help"),
)
