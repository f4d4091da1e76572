"""Writes files for the verbs of ``bag`` atomically: a file is written completely or not at all."""

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
from pyros1.ground.interrupts import TERMINATION_SIGNALS, InterruptCounter, install_handler, is_default_handler


@contextmanager
def new_file(target: str) -> Iterator[str]:
    """Yield the name of a temporary file, which becomes `target` on success and is removed otherwise.

    A symbolic link is kept: the file that it points to is written.

    Raises:
        IsADirectoryError: The target is a folder.
        CommandError: The target is a device or a pipe, or a signal interrupted the command.
    """
    if os.path.isdir(target):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), target)
    _check_replaceable(target)
    real_target = os.path.realpath(target)
    temporary_path = f"{real_target}.tmp"
    with clean_up_on_signal(f"{target} was not written"):
        try:
            yield temporary_path
            os.replace(temporary_path, real_target)
        except BaseException as error:
            with contextlib.suppress(OSError):
                os.unlink(temporary_path)
            if isinstance(error, BagError) and error.path == temporary_path:
                raise type(error)(target, error.reason, error.offset) from error
            if isinstance(error, OSError) and error.filename in (None, temporary_path):
                error.filename = target
            raise


def _check_replaceable(target: str) -> None:
    """Check that a file can take the place of a target: a device such as /dev/null must not be replaced.

    Raises:
        CommandError: The target is a device, a pipe or a socket.
    """
    if os.path.exists(target) and not os.path.isfile(target) and not os.path.isdir(target):
        raise CommandError(f"{target} is a device or a pipe: give the name of a file")


@contextmanager
def clean_up_on_signal(consequence: str) -> Iterator[None]:
    """Turn Ctrl-C, SIGTERM and SIGHUP into an error, so that incomplete files can be removed.

    Args:
        consequence: What the interruption means for the files, for the error message.

    Raises:
        CommandError: One of these signals arrived.
    """
    received_signal = signal.SIGINT
    interrupts = InterruptCounter()

    def interrupt(number: int, _: object) -> None:
        nonlocal received_signal
        if interrupts.count_signal():  # a second signal must not interrupt the cleanup after the first
            received_signal = signal.Signals(number)
            raise KeyboardInterrupt

    restore_handlers = install_handler(
        interrupt, [number for number in TERMINATION_SIGNALS if is_default_handler(signal.getsignal(number))]
    )
    try:
        yield
    except KeyboardInterrupt:
        raise CommandError(f"interrupted: {consequence}", 128 + received_signal, plain=True) from None
    finally:
        restore_handlers()


def check_different(source: str, target: str, code: int = 1) -> None:
    """Raise an error if both paths refer to the same file.

    Args:
        source: The input file.
        target: The output file.
        code: The exit status of the command after this error.

    Raises:
        CommandError: Both paths refer to the same file.
    """
    if os.path.realpath(source) == os.path.realpath(target):
        raise CommandError(f"Cannot use same file as input and output [{source}]", code, plain=True)


@contextmanager
def write_atomically(target: str, *, is_folder: bool, force: bool) -> Iterator[str]:
    """Yield the name of a temporary file or folder, which becomes `target` on success and is removed otherwise.

    If the target folder exists, the new files are moved into it. Old files of the same name are replaced; others stay.

    Args:
        target: The file or folder to create.
        is_folder: Whether the target is a folder.
        force: Whether to replace an existing target. An existing empty folder is always accepted.

    Raises:
        CommandError: The target exists or is of the wrong kind, its parent folder does not exist, or a signal
            interrupted the command.
    """
    target = os.path.normpath(target)
    if os.path.isdir(target) and not is_folder:
        raise CommandError(f"{target} is a folder: give the name of a file")
    _check_replaceable(target)
    if os.path.lexists(target) and not os.path.isdir(target) and is_folder:
        raise CommandError(f"{target} is a file: give the name of a folder")
    if os.path.lexists(target) and not force and not (is_folder and not os.listdir(target)):
        raise CommandError(f"{target} already exists: use -f to replace it")
    parent = os.path.dirname(target)
    if parent and not os.path.isdir(parent):
        raise CommandError(f"the folder {parent} does not exist")
    work_folder = f"{target}.{os.getpid()}.tmp"
    temporary_path = os.path.join(work_folder, os.path.basename(target))
    with clean_up_on_signal(f"{target} was not written"):
        try:
            os.mkdir(work_folder)
            yield temporary_path
            _move_into_place(temporary_path, target)
        except BagError as error:
            if error.path.startswith(work_folder):
                raise type(error)(target, error.reason, error.offset) from error
            raise
        except OSError as error:
            if error.filename is None or str(error.filename).startswith(work_folder):
                error.filename = target
            raise
        finally:
            shutil.rmtree(work_folder, ignore_errors=True)


def _move_into_place(temporary_path: str, target: str) -> None:
    """Move a file or folder to its final name. The contents of a folder are moved into an existing folder."""
    if not os.path.isdir(target) or not os.path.isdir(temporary_path):
        os.replace(temporary_path, target)
        return
    for name in sorted(os.listdir(temporary_path)):
        _move_into_place(os.path.join(temporary_path, name), os.path.join(target, name))
