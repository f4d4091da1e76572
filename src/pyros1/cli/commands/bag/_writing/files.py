"""What the verbs of ``bag`` that make files share: one is there whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import signal
from collections.abc import Iterator
from contextlib import contextmanager

from pyros1.bag.errors import BagError
from pyros1.cli.failures import CommandError
from pyros1.interrupts import ENDINGS, Insistence, catch, is_usual


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


@contextmanager
def whole_or_nothing(target: str, *, folder: bool, force: bool) -> Iterator[str]:
    """Give the name of a file or folder to make, which becomes `target` if all goes well, and vanishes if not.

    A folder that is there already gets what was made: files of the same names are replaced, others stay.

    Args:
        target: what to make.
        folder: it is a folder.
        force: it may be there already; an empty folder always may.

    Raises:
        CommandError: it is there, or something else is; there is no folder for it, or a signal told the command to end.
    """
    target = os.path.normpath(target)
    if os.path.isdir(target) and not folder:
        raise CommandError(f"{target} is a folder, and a file is to be written")
    if os.path.lexists(target) and not os.path.isdir(target) and folder:
        raise CommandError(f"{target} is a file, and a folder is to be written")
    if os.path.lexists(target) and not force and not (folder and not os.listdir(target)):
        raise CommandError(f"{target} is there already; -f replaces it")
    parent = os.path.dirname(target)
    if parent and not os.path.isdir(parent):
        raise CommandError(f"there is no folder {parent}")
    work = f"{target}.{os.getpid()}.tmp"
    part = os.path.join(work, os.path.basename(target))
    with interruptible(f"{target} was not written"):
        try:
            os.mkdir(work)
            yield part
            _move(part, target)
        except BagError as error:
            if error.path.startswith(work):
                raise type(error)(target, error.reason, error.offset) from error
            raise
        except OSError as error:
            if error.filename is None or str(error.filename).startswith(work):
                error.filename = target
            raise
        finally:
            shutil.rmtree(work, ignore_errors=True)


def _move(part: str, target: str) -> None:
    if not os.path.isdir(target) or not os.path.isdir(part):
        os.replace(part, target)
        return
    for name in sorted(os.listdir(part)):
        _move(os.path.join(part, name), os.path.join(target, name))
