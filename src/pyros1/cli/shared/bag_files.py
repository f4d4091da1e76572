"""Checks the bags named on the command line before the web page opens them."""

from __future__ import annotations

import os

from pyros1.bag.errors import BagError
from pyros1.bag.format.files import BagFile
from pyros1.cli.failures import CommandError, did_you_mean
from pyros1.ground.terminal_text import one_line


def check_bag(path: str) -> None:
    """Check that a file starts like a bag. Bags that were not closed are accepted.

    Args:
        path: the path of the file.

    Raises:
        CommandError: the file does not exist, cannot be read, or is not a bag.
    """
    try:
        BagFile(path).close()
        return
    except (FileNotFoundError, IsADirectoryError):
        pass
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise CommandError(f"cannot read {one_line(path)}: {reason}") from None
    except BagError as error:
        raise CommandError(one_line(str(error))) from None
    if os.path.isdir(path):
        raise CommandError(f"{one_line(path)} is a folder, not a bag; --bags {one_line(path)} shows its bags")
    folder = os.path.dirname(path)
    try:
        sibling_bags = [
            os.path.join(folder, name) for name in os.listdir(folder or ".") if name.endswith((".bag", ".active"))
        ]
    except OSError:
        sibling_bags = []
    raise CommandError(f"there is no file {one_line(path)}{did_you_mean(path, sibling_bags)}")
