"""Formats the errors of ``bag`` about unreadable bags and unwritable files."""

from __future__ import annotations

import errno
import sys

from pyros1.bag.errors import BagError, UnindexedError
from pyros1.cli.failures import flush_stdout
from pyros1.cli.output import STDOUT_NAME

_WRITE_ERROR_NUMBERS = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT, errno.EROFS)


def format_error(error: Exception) -> str | None:
    """Return the message for an error about a bag or another file; None for any other error."""
    if isinstance(error, UnindexedError):
        return f"ERROR bag unindexed: {error}"
    if isinstance(error, BagError):
        return f"ERROR reading {error}"
    if isinstance(error, OSError) and error.filename != STDOUT_NAME:
        return f"ERROR {error.filename}: {error.strerror}" if error.filename else f"ERROR: {error.strerror or error}"
    return None


def report_bag_error(error: BagError | OSError, path: str) -> None:
    """Print to stderr why a bag cannot be read or written. The command can then continue with other bags."""
    flush_stdout()
    if isinstance(error, BagError):
        print(format_error(error), file=sys.stderr)
    else:
        operation = "writing" if error.errno in _WRITE_ERROR_NUMBERS else "reading"
        failed_action = f"{operation} {path}" if error.filename in (None, path) else error.filename
        print(f"ERROR {failed_action}: {error.strerror or error}", file=sys.stderr)
