"""Checks of bags that the command line names, before a page opens for them."""

from __future__ import annotations

import os

from pyros1.bag.errors import BagError
from pyros1.bag.format.files import BagFile
from pyros1.cli.failures import CommandError, did_you_mean
from pyros1.ground.terminal_text import one_line


def check_bag(word: str) -> None:
    """Check that a file begins like a bag. Bags that were not closed pass.

    Args:
        word: its path, as the user wrote it.

    Raises:
        CommandError: there is no such file, it cannot be read, or is not a bag.
    """
    try:
        BagFile(word).close()
        return
    except (FileNotFoundError, IsADirectoryError):
        pass
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise CommandError(f"cannot read {one_line(word)}: {reason}") from None
    except BagError as error:
        raise CommandError(one_line(str(error))) from None
    if os.path.isdir(word):
        raise CommandError(f"{one_line(word)} is a folder, not a bag; --bags {one_line(word)} shows its bags")
    folder = os.path.dirname(word)
    try:
        others = [
            os.path.join(folder, name) for name in os.listdir(folder or ".") if name.endswith((".bag", ".active"))
        ]
    except OSError:
        others = []
    raise CommandError(f"there is no file {one_line(word)}{did_you_mean(word, others)}")
