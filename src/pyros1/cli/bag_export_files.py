"""Where exports go: a file or a folder that is there whole or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager

from pyros1.bag.errors import BagError
from pyros1.cli.bag_files import interruptible
from pyros1.cli.common import CommandError


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
