"""``pyros1 topic``: inspects, measures and publishes topics, like rostopic (L25-L30, L60-L69)."""

from __future__ import annotations

from pyros1.cli.records import Command

COMMAND = Command(
    "topic",
    "inspect, measure and publish topics",
    group="inspect",
    stock="rostopic",
    heading="{program} is a command-line tool for printing information about ROS Topics.\n\nCommands:",
    row="\t{program} {name}\t{about}",
    footer="\nType {program} <command> -h for more detailed usage, e.g. '{program} echo -h'\n",
)
