"""``pyros1 bag``: rosbag. Each verb is in a file of its own, imported when it is asked for."""

from __future__ import annotations

import sys
from importlib import import_module
from keyword import iskeyword

from pyros1.bag.errors import BagError, UnindexedError
from pyros1.cli.common import Invocation, flush, run
from pyros1.cli.output import NAME

_VERBS = {
    "play": ("bag_play", "play back the contents of one or more bag files in a time-synchronized fashion"),
    "record": ("bag_record", "record a bag file with the contents of specified topics"),
    "info": ("bag_info", "summarize the contents of one or more bag files"),
    "filter": ("bag_filter", "choose messages by an expression, topics, times"),
    "compress": ("bag_edit", "compress one or more bag files"),
    "decompress": ("bag_edit", "decompress one or more bag files"),
    "check": ("bag_fix", "see whether the messages fit the definitions of this system"),
    "fix": ("bag_fix", "bring the messages to the definitions of this system"),
    "reindex": ("bag_edit", "save bags that were not closed or are damaged"),
    "encrypt": ("bag_encrypt", "encrypt one or more bag files"),
    "decrypt": ("bag_encrypt", "decrypt one or more bag files"),
    "merge": ("bag_edit", "make one bag of several"),
    "split": ("bag_edit", "make several bags of one"),
    "rename-topic": ("bag_edit", "rename topics"),
    "retime": ("bag_edit", "move the times of messages"),
    "export": ("bag_export", "write CSV, JSON, images, videos, MCAP files or ROS 2 bags"),
    "import": ("bag_import", "make a bag of a ROS 2 bag or MCAP file"),
}
"""Verb -> module in pyros1.cli, and what it does."""

_SCRIPTS = {
    "bagsort.py": "bagsort",
    "fastrebag.py": "bagsort",
    "fix_md5sums.py": "fix_md5sums",
    "fix_moved_messages.py": "fix_moved_messages",
    "fix_msg_defs.py": "fix_msg_defs",
    "fixbag.py": "fixbag",
    "fixbag_batch.py": "fixbag_batch",
    "makerule.py": "makerule",
    "savemsg.py": "savemsg",
    "topic_renamer.py": "topic_renamer",
}
"""Script of the package rosbag -> function in `bag_scripts`; the list of commands does not name them."""


def usage(program: str) -> str:
    """The command list."""
    lines = [f"Usage: {program} <subcommand> [options] [args]", ""]
    lines += ["A bag is a file of recorded ROS messages: record, play, look at and change them.", ""]
    lines += ["Available subcommands:"]
    lines += [f"   {name:13} {about}" for name, (_, about) in sorted(_VERBS.items())]
    lines += ["", f"Type {program} <subcommand> -h for more detailed usage"]
    return "\n".join(lines)


def _verb(invocation: Invocation) -> int | None:
    """Run the verb that was asked for."""
    if invocation.verb in _SCRIPTS:
        module, name = "bag_scripts", _SCRIPTS[invocation.verb]
    else:
        module, name = _VERBS[invocation.verb][0], invocation.verb.replace("-", "_")
    code: int | None = 1
    function = getattr(import_module(f"pyros1.cli.{module}"), f"{name}_" if iskeyword(name) else name)
    try:
        code = function(invocation)
        return code
    except UnindexedError as error:
        text = f"ERROR bag unindexed: {error}"
    except BagError as error:
        text = f"ERROR reading {error}"
    except OSError as error:
        if isinstance(error, BrokenPipeError) or error.filename == NAME:
            raise
        text = f"ERROR {error.filename}: {error.strerror}" if error.filename else f"ERROR: {error.strerror or error}"
    flush()
    print(text, file=sys.stderr)
    return code


def main(argv: list[str]) -> int:
    """Run ``bag <verb> ...``; returns the exit code."""
    if not argv or argv[0] in ("help", "-h", "--help"):
        if len(argv) > 1 and argv[1] in _VERBS:
            return main([argv[1], "-h"])
        print(usage(Invocation("rosbag", []).program))
        return 0
    return run("rosbag", argv, dict.fromkeys([*_VERBS, *_SCRIPTS], _verb), usage)
