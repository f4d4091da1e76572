"""The tool rosbag, as functions: each takes the words after its verb; and what it does to bags."""

from __future__ import annotations

import sys
from typing import Any

from pyros1.drop_in.commands import main, run
from pyros1.drop_in.missing import names

_TOOL = ("ProgressMeter", "RosbagCmds", "bag_op", "handle_pause_topics", "handle_split", "handle_topics", "print_trans")
__getattr__, __dir__ = names(__name__, dict.fromkeys(_TOOL, "rosbag._tool"))


def _verb(verb: str, argv: list[str]) -> None:
    code = run("rosbag", verb, *argv)
    if code:
        sys.exit(code)


def record_cmd(argv: list[str]) -> None:
    """Record topics."""
    _verb("record", argv)


def info_cmd(argv: list[str]) -> None:
    """Print facts about bags."""
    _verb("info", argv)


def play_cmd(argv: list[str]) -> None:
    """Play bags."""
    _verb("play", argv)


def filter_cmd(argv: list[str]) -> None:
    """Write a bag with some messages of another."""
    _verb("filter", argv)


def check_cmd(argv: list[str]) -> None:
    """Tell whether a bag's messages are of this system's definitions."""
    _verb("check", argv)


def fix_cmd(argv: list[str]) -> None:
    """Convert a bag's messages to this system's definitions."""
    _verb("fix", argv)


def compress_cmd(argv: list[str]) -> None:
    """Compress bags."""
    _verb("compress", argv)


def decompress_cmd(argv: list[str]) -> None:
    """Decompress bags."""
    _verb("decompress", argv)


def reindex_cmd(argv: list[str]) -> None:
    """Repair bags that were not closed."""
    _verb("reindex", argv)


def encrypt_cmd(argv: list[str]) -> None:
    """Encrypt bags."""
    _verb("encrypt", argv)


def decrypt_cmd(argv: list[str]) -> None:
    """Decrypt bags."""
    _verb("decrypt", argv)


def rosbagmain(argv: list[str] | None = None) -> None:
    """Run the tool with a command line; None: that of the process."""
    main("rosbag", argv)


# Operations ---------------------------------------------------------------------------------------------------------


def change_compression_op(inbag: Any, outbag: Any, compression: str, quiet: bool) -> None:
    """Write all messages of a bag into another, with a compression."""
    outbag.compression = compression
    for topic, message, stamp, header in inbag.read_messages(raw=True, return_connection_header=True):
        outbag.write(topic, message, stamp, raw=True, connection_header=header)


def change_encryption_op(inbag: Any, outbag: Any, plugin: str, param: str, compression: str, quiet: bool) -> None:
    """Write all messages of a bag into another, encrypted."""
    outbag.set_encryptor(plugin, param)
    change_compression_op(inbag, outbag, compression, quiet)


def reindex_op(inbag: Any, outbag: Any, quiet: bool) -> None:
    """Reindex `outbag`, which is a copy of `inbag`."""
    for _ in outbag.reindex():
        pass
