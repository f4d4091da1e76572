"""Commands that have no record yet."""

from __future__ import annotations

from importlib import import_module

OLD = {
    "node": ("node_cmd", "show and end nodes: list info ping machine kill cleanup"),
    "service": ("service", "show and call services: list info type uri node args find call"),
    "param": ("param", "show and set parameters: list get set load dump delete"),
    "msg": ("msg", "show message types: show list md5 package packages"),
    "srv": ("srv", "show service types: show list md5 package packages"),
    "log": ("log", "show and set log levels, print log messages: list get set echo"),
    "graph": ("graph_cmd", "print nodes and their connections"),
    "topic_tools": ("topic_tools", "forward topics: relay drop throttle mux demux transform relay_field"),
    "tf": ("tf", "show and publish coordinate frames: echo monitor tree view_frames static_transform_publisher"),
    "dynparam": ("dynparam", "show and change parameters of running nodes: list get set set_from_parameters load dump"),
    "diagnostic": ("diagnostic", "show what the robot's parts say of their state"),
    "msg-proto": ("msg_proto", "print a message or service request to fill in"),
    "bag": ("bag", "record, play, look at and change bags: info reindex filter compress merge ..."),
}
"""Command -> module in pyros1.cli, and what it does."""
CALLED_OTHERWISE = {"rosconsole": "log"}
"""Stock name -> command, where that is not what follows ``ros``."""


def legacy_name(word: str) -> str | None:
    """The command that a word means: ``topic`` or, by its stock name, ``rostopic``. None if there is none."""
    if word in OLD:
        return word
    if word in CALLED_OTHERWISE:
        return CALLED_OTHERWISE[word]
    return word[3:] if word.startswith("ros") and word[3:] in OLD else None


def run_old(command: str, argv: list[str]) -> int:
    code: int = import_module(f"pyros1.cli.{OLD[command][0]}").main(argv)
    return code
