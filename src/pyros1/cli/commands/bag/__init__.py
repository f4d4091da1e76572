"""``pyros1 bag``: records, plays, inspects and edits bags, like rosbag (L90-L145)."""

from __future__ import annotations

from pyros1.cli.commands.bag._failures import format_error
from pyros1.cli.records import Command

COMMAND = Command(
    "bag",
    "record, play, inspect and edit bags",
    group="files",
    stock="rosbag",
    heading="Usage: {program} <subcommand> [options] [args]\n\n"
    "A bag is a file of recorded ROS messages. {program} records, plays, inspects and edits bags.\n\n"
    "Available subcommands:",
    row="   {name:13} {about}",
    footer="\nType {program} <subcommand> -h for more detailed usage",
    format_error=format_error,
    stock_help=("", "-h", "--help", "help"),
    prints_unknown_verb=True,
)
