"""What the verbs of ``bag`` that make new files share: names, backups, whole files or none, and times."""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import datetime
from decimal import Decimal, InvalidOperation

from pyros1.bag.errors import BagError
from pyros1.bag.reader import BagReader
from pyros1.cli.bag_info import report_bag_error
from pyros1.cli.common import CommandError
from pyros1.interrupts import ENDINGS, Insistence, catch, is_usual

_NS = 1_000_000_000


@contextmanager
def new_file(target: str) -> Iterator[str]:
    """Give the name of a file to write, which becomes `target` if all goes well, and vanishes if not.

    Raises:
        CommandError: a signal told the command to end.
    """
    part = f"{target}.tmp"
    if os.path.isdir(target):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), target)
    with interruptible(f"{target} was not written"):
        try:
            yield part
            os.replace(part, target)
        except BaseException as error:
            with contextlib.suppress(OSError):
                os.unlink(part)
            if isinstance(error, BagError) and error.path == part:
                raise type(error)(target, error.reason, error.offset) from error
            if isinstance(error, OSError) and error.filename in (None, part):
                error.filename = target
            raise


@contextmanager
def interruptible(consequence: str) -> Iterator[None]:
    """Let Ctrl-C, SIGTERM and SIGHUP end the work with an error, so that what is half done can be removed.

    Args:
        consequence: said to the user.

    Raises:
        CommandError: one of them came.
    """
    came = signal.SIGINT
    insistence = Insistence()

    def end(number: int, _: object) -> None:
        nonlocal came
        if insistence.again():  # another one that comes with the first must not end what that sets off
            came = signal.Signals(number)
            raise KeyboardInterrupt

    restore = catch(end, [number for number in ENDINGS if is_usual(signal.getsignal(number))])
    try:
        yield
    except KeyboardInterrupt:
        raise CommandError(f"interrupted: {consequence}", 128 + came, plain=True) from None
    finally:
        restore()


def different(source: str, target: str, code: int = 1) -> None:
    """End the command if both are the same file."""
    if os.path.realpath(source) == os.path.realpath(target):
        raise CommandError(f"Cannot use same file as input and output [{source}]", code, plain=True)


def rewrite_each(
    paths: list[str],
    operation: Callable[[str, str], object],
    *,
    output_dir: str | None,
    force: bool,
    quiet: bool,
) -> int:
    """Make a new bag of each one, in its place with the old one kept as ``NAME.orig.bag``, or in a folder.

    The old file is moved only when the new one is complete.

    Args:
        operation: given the old file and the new one, writes that.
        output_dir: where new files go; None means in the place of the old ones.
        force: replace backups.
        quiet: say nothing about backups.

    Returns:
        The exit code: 1 if a file could not be made.
    """
    failed = False
    for path in paths:
        try:
            if output_dir is not None:
                target = os.path.join(output_dir, os.path.basename(path))
                different(path, target)
                with new_file(target) as part:
                    operation(path, part)
                continue
            stem, extension = os.path.splitext(path)
            backup = f"{stem}.orig{extension}"
            if os.path.exists(backup) and not force:
                if not quiet:
                    print(f"Skipping {path}. Backup path {backup} already exists.", file=sys.stderr)
                continue
            with new_file(path) as part:
                operation(path, part)
                shutil.copymode(path, part)
                keep(path, backup)
        except (BagError, OSError) as error:
            report_bag_error(error, path)
            failed = True
    return int(failed)


def keep(path: str, backup: str) -> None:
    """Give a file another name as well, so that there is one under its own at every moment."""
    link = f"{backup}.tmp"
    try:
        os.link(path, link)
    except OSError:
        os.replace(path, backup)  # the file system knows no links
    else:
        os.replace(link, backup)


def parse_time(text: str, bag: BagReader | None, option: str) -> int:
    """Return a time from the command line, in nanoseconds.

    Args:
        text: seconds from the beginning of the bag, or from its end if negative; ``@`` and seconds since 1970; or a
            local date and time such as ``2026-11-20T20:10:31``.
        bag: the bag; None if only an absolute time makes sense.
        option: named in errors.

    Raises:
        CommandError: it is none of these.
    """
    try:
        if text.startswith("@"):
            return int(Decimal(text[1:]) * _NS)
        try:
            offset = int(Decimal(text) * _NS)
        except InvalidOperation:
            return round(datetime.fromisoformat(text).timestamp() * 1e6) * 1000
    except (InvalidOperation, ValueError, OverflowError):
        raise CommandError(
            f"{option}: {text!r} is not a time: give seconds from the beginning (negative ones count from the end), "
            "@ and seconds since 1970, or a date such as 2026-11-20T20:10:31",
            2,
        ) from None
    if bag is None:
        return offset
    return (bag.end if text.startswith("-") else bag.start) + offset
