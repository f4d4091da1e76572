"""``pkg cd``: prints the folder for the shell function ``roscd`` (L184)."""

from __future__ import annotations

import os

from pyros1.cli.commands.pkg._files import FilesError, files_verb, folder_of, home_of_packages
from pyros1.cli.records import Argument


def _cd(words: list[str]) -> int:
    if len(words) > 1 or words in (["-h"], ["--help"]):
        raise FilesError("usage: roscd [package[/folder]]")
    path = folder_of(words[0]) if words and words[0] else home_of_packages()
    if not os.path.isdir(path):
        raise FilesError(f"{path} is not a folder")
    print(path)
    return 0


VERB = files_verb(
    "cd",
    "roscd",
    _cd,
    Argument("package[/folder]", "package|place", optional=True),
    about="print a package's folder",
    examples=[("roscpp", "the folder that `roscd roscpp` changes to")],
)
