"""Shared code of the verbs that rewrite bags: compress, decompress, encrypt, decrypt and reindex."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable
from typing import Any

from pyros1.bag.errors import BagError
from pyros1.cli.commands.bag._failures import report_bag_error
from pyros1.cli.commands.bag._options import QUIET_FLAG
from pyros1.cli.commands.bag._writing.files import check_different, new_file
from pyros1.cli.failures import UsageError
from pyros1.cli.records import Argument, Flag, Option
from pyros1.cli.shared.options import CHUNK_LIMIT_OPTION

REWRITE_OPTIONS = (
    CHUNK_LIMIT_OPTION,
    Option("--output-dir", metavar="DIR", help="write to directory DIR"),
    Flag("-f", "--force", help="force overwriting of backup file if it exists"),
    QUIET_FLAG,
)
"""The options that `rewrite_each` uses."""
BAGS_ARGUMENT = Argument("BAGFILE", "bag", repeatable=True)
REWRITE_USAGE = "[options] BAGFILE1 [BAGFILE2 ...]"


def rewrite_each(options: Any, paths: list[str], operation: Callable[[str, str], object]) -> int:
    """Rewrite each bag, either in place, keeping the old one as ``NAME.orig.bag``, or into a folder.

    The old file is replaced only after the new one is complete.

    Args:
        options: The parsed options, see `REWRITE_OPTIONS`.
        paths: The paths of the bags.
        operation: Reads the file named by its first argument and writes the file named by its second.

    Returns:
        The exit status: 1 if a bag could not be read or written, otherwise 0.

    Raises:
        UsageError: No bag is given.
    """
    if not paths:
        raise UsageError("You must specify at least one bag file.")
    has_failed = False
    for path in paths:
        try:
            if options.output_dir is not None:
                target = os.path.join(options.output_dir, os.path.basename(path))
                check_different(path, target)
                with new_file(target) as temporary_path:
                    operation(path, temporary_path)
                continue
            stem, extension = os.path.splitext(path)
            backup = f"{stem}.orig{extension}"
            if os.path.exists(backup) and not options.force:
                if not options.quiet:
                    print(f"Skipping {path}. Backup path {backup} already exists.", file=sys.stderr)
                continue
            with new_file(path) as temporary_path:
                operation(path, temporary_path)
                shutil.copymode(path, temporary_path)
                _back_up(path, backup)
        except (BagError, OSError) as error:
            report_bag_error(error, path)
            has_failed = True
    return int(has_failed)


def _back_up(path: str, backup: str) -> None:
    """Give a file a second name by a hard link. If the file system does not support hard links, rename the file."""
    temporary_link = f"{backup}.tmp"
    try:
        os.link(path, temporary_link)
    except OSError:
        os.replace(path, backup)  # the file system does not support hard links
    else:
        os.replace(temporary_link, backup)
