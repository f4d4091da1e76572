"""The tool rosbag: a function for each subcommand, called with the subcommand's arguments."""

from __future__ import annotations

import sys

from pyros1.drop_in.commands import main, run
from pyros1.drop_in.module_attributes import module_getattr
from rosbag._progress import ProgressMeter

_ALTERNATIVE = "see rosbag.Bag, or this module's functions for subcommands, such as compress_cmd"
__getattr__ = module_getattr(
    __name__,
    RosbagCmds="see rosbagmain",
    bag_op=_ALTERNATIVE,
    change_compression_op=_ALTERNATIVE,
    change_encryption_op=_ALTERNATIVE,
    print_trans=_ALTERNATIVE,
    reindex_op=_ALTERNATIVE,
)


def _run_verb(verb: str, argv: list[str]) -> None:
    code = run("rosbag", verb, *argv)
    if code:
        sys.exit(code)


def record_cmd(argv: list[str]) -> None:
    """Record topics."""
    _run_verb("record", argv)


def info_cmd(argv: list[str]) -> None:
    """Print information about bags."""
    _run_verb("info", argv)


def play_cmd(argv: list[str]) -> None:
    """Play bags."""
    _run_verb("play", argv)


def filter_cmd(argv: list[str]) -> None:
    """Write a bag with selected messages from another bag."""
    _run_verb("filter", argv)


def check_cmd(argv: list[str]) -> None:
    """Print whether a bag's messages match this system's definitions."""
    _run_verb("check", argv)


def fix_cmd(argv: list[str]) -> None:
    """Convert a bag's messages to this system's definitions."""
    _run_verb("fix", argv)


def compress_cmd(argv: list[str]) -> None:
    """Compress bags."""
    _run_verb("compress", argv)


def decompress_cmd(argv: list[str]) -> None:
    """Decompress bags."""
    _run_verb("decompress", argv)


def reindex_cmd(argv: list[str]) -> None:
    """Repair bags that were not closed."""
    _run_verb("reindex", argv)


def encrypt_cmd(argv: list[str]) -> None:
    """Encrypt bags."""
    _run_verb("encrypt", argv)


def decrypt_cmd(argv: list[str]) -> None:
    """Decrypt bags."""
    _run_verb("decrypt", argv)


def rosbagmain(argv: list[str] | None = None) -> None:
    """Run the tool with a command line; None for the process's command line."""
    main("rosbag", argv)
