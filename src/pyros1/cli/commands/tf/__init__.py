"""``pyros1 tf``: shows and publishes coordinate frames (L195-L199)."""

from __future__ import annotations

from pyros1.cli.records import Command

COMMAND = Command(
    "tf",
    "show and publish coordinate frames",
    group="inspect",
    heading="{program} shows and publishes coordinate frames.\n\nCommands:",
    order=[
        "echo",
        "monitor",
        "tree",
        "view_frames",
        "static_transform_publisher",
        "remap",
        "buffer_server",
        "change_notifier",
    ],
    row="\t{program} {name:27} {about}",
    footer="\nType {program} <command> -h for more detailed usage, e.g. '{program} echo -h'",
)
