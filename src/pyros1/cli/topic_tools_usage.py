"""What the tools of topic_tools say about themselves."""

from __future__ import annotations

from pyros1.cli.usage import examples_text

_WIKI = "https://wiki.ros.org/topic_tools"
_INPUT = "IN_TOPIC"

ABOUT: dict[str, tuple[str, str]] = {
    "relay": ("IN_TOPIC [OUT_TOPIC]", "publishes a topic again, by default as IN_TOPIC_relay"),
    "drop": ("IN_TOPIC X Y [OUT_TOPIC]", "leaves out the first X of every Y messages; IN_TOPIC_drop"),
    "throttle": (
        "messages IN_TOPIC MSGS_PER_SEC [OUT_TOPIC]\n       throttle bytes IN_TOPIC BYTES_PER_SEC WINDOW [OUT_TOPIC]",
        "lets so many messages pass per second, or bytes within WINDOW seconds; IN_TOPIC_throttle",
    ),
    "mux": ("OUT_TOPIC IN_TOPIC1 [IN_TOPIC2 [...]]", "publishes one of several topics, as the service mux/select says"),
    "demux": ("IN_TOPIC OUT_TOPIC1 [OUT_TOPIC2 [...]]", "publishes on one of several topics, as demux/select says"),
    "transform": (
        "IN_TOPIC[/FIELD] OUT_TOPIC OUT_TYPE [EXPRESSION]",
        "publishes what an expression makes of m",
    ),
    "relay_field": (
        "IN_TOPIC[/FIELD] OUT_TOPIC OUT_TYPE YAML",
        "publishes expressions of m as fields",
    ),
    "mux_select": ("MUX TOPIC", "selects the mux's input, or none: __none"),
    "mux_add": ("MUX TOPIC", "adds an input"),
    "mux_delete": ("MUX TOPIC", "deletes an input"),
    "mux_list": ("MUX", "lists the inputs"),
    "demux_select": ("DEMUX TOPIC", "selects the demux's output, or none: __none"),
    "demux_add": ("DEMUX TOPIC", "adds an output"),
    "demux_delete": ("DEMUX TOPIC", "deletes an output"),
    "demux_list": ("DEMUX", "lists the outputs"),
    "switch_mux": ("MUXED_TOPIC SELECT_TOPIC", "deprecated: mux_select, by the name of the mux's output"),
}
"""Tool -> its arguments, and what it does."""

_LAZY = "_lazy:=true        subscribe only while somebody listens"
_PARAMETERS: dict[str, list[str]] = {
    "relay": [
        _LAZY,
        "_stealth:=true     subscribe only while another node listens to _monitor_topic:=/topic (the output),",
        "                   which the master is asked _monitor_rate:=1.0 times a second",
    ],
    "throttle": [
        _LAZY,
        "_wall_clock:=true  do not measure simulated time",
        "_force_latch:=true (or false) latch the output or not, whatever the input does",
    ],
    "mux": [
        _LAZY,
        "_latch:=true       latch the output",
        "_initial_topic:=/topic (or __none) select it at the start",
        "_wait_publisher_initialization:=true the first message waits _wait_publisher_second:=0.1 for subscribers",
    ],
}
_EXAMPLES: dict[str, dict[str, str]] = {
    "relay": {"%prog /base_scan /scan": "one more name for a topic"},
    "drop": {"%prog /scan 4 5 /few": "every fifth message"},
    "throttle": {
        "%prog messages /scan 2": "/scan_throttle: two messages a second",
        "%prog bytes /image 1000000 1": "/image_throttle: less than a megabyte a second",
    },
    "mux": {"%prog /cmd_vel /joystick /planner mux:=mux_vel": "services mux_vel/select, ..."},
    "demux": {"%prog /cmd /left/cmd /right/cmd": "services demux/select, ..."},
    "mux_select": {"%prog mux_vel /planner": ""},
}


def usage_line(tool: str) -> str:
    """Return the line that says which arguments a tool takes."""
    return f"usage: {tool} {ABOUT[tool][0]}"


def help_text(tool: str) -> str:
    """Return a tool's help; of all tools if the name is empty."""
    if not tool:
        lines = ["usage: pyros1 topic_tools <tool> [arguments]", "", "Tools:"]
        lines += [f"  {name:12} {about}" for name, (_, about) in ABOUT.items()]
        return "\n".join([*lines, "", f"Type pyros1 topic_tools <tool> -h for more, or see {_WIKI}."])
    about = ABOUT[tool][1]
    text = f"{usage_line(tool)}\n\n{about[0].upper()}{about[1:]}.\n"
    if tool in _PARAMETERS:
        text += "\nParameters:\n" + "".join(f"  {line}\n" for line in _PARAMETERS[tool])
    if tool in _EXAMPLES:
        text += examples_text(f"pyros1 topic_tools {tool}", _EXAMPLES[tool])
    return text.rstrip("\n")
