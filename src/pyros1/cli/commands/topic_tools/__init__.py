"""``pyros1 topic_tools``: the tools of the ROS package topic_tools, as commands and as nodes (L187-L194).

The package ``topic_tools`` in `pyros1.packages` has a script for each tool, which runs the same command.
"""

from __future__ import annotations

from pyros1.cli.records import Command

COMMAND = Command(
    "topic_tools",
    "forward, throttle and transform topics",
    group="inspect",
    heading="usage: {program} <tool> [arguments]\n\nTools:",
    order=[
        *("relay", "drop", "throttle", "mux", "demux", "transform", "relay_field"),
        *("mux_select", "mux_add", "mux_delete", "mux_list"),
        *("demux_select", "demux_add", "demux_delete", "demux_list", "switch_mux"),
    ],
    row="  {name:12} {about}",
    footer="\nType {program} <tool> -h for more, or see https://wiki.ros.org/topic_tools.",
)
