"""``bag compress`` and ``bag decompress``: rewrite bags with or without compression (L142)."""

from __future__ import annotations

from typing import Any

from pyros1.bag.edit import editing as edit
from pyros1.bag.format.reader import BagReader
from pyros1.cli.commands.bag._options import compression_options
from pyros1.cli.commands.bag._writing.rewrite import BAGS_ARGUMENT, REWRITE_OPTIONS, REWRITE_USAGE, rewrite_each
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb
from pyros1.cli.shared.progress import Progress


def compress(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Rewrite bags with the compression that the options select. Return the exit code."""
    return _recompress(options, args, options.compression)


def decompress(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Rewrite bags without compression. Return the exit code."""
    return _recompress(options, args, "none")


VERBS = [
    Verb(
        "compress",
        "compress one or more bag files",
        *REWRITE_OPTIONS,
        *compression_options("bz2"),
        BAGS_ARGUMENT,
        usage=REWRITE_USAGE,
        description="Compress one or more bag files.",
        examples=[("--lz4 *.bag", "compress bags in place and keep backups")],
        run=compress,
    ),
    Verb(
        "decompress",
        "decompress one or more bag files",
        *REWRITE_OPTIONS,
        BAGS_ARGUMENT,
        usage=REWRITE_USAGE,
        description="Decompress one or more bag files.",
        examples=[("run.bag", "decompress a bag in place and keep a backup")],
        run=decompress,
    ),
]


def _recompress(options: Any, paths: list[str], new_compression: str) -> int:
    def recompress_bag(source: str, target: str) -> None:
        with BagReader(source) as bag, Progress(source, bag.content_size(), quiet=options.quiet) as progress:
            edit.copy(bag.messages(), target, compression=new_compression, cipher=bag.file.cipher, progress=progress)

    return rewrite_each(options, paths, recompress_bag)
