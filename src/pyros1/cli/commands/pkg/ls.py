"""``pkg ls``: rosls (L184)."""

from __future__ import annotations

import subprocess
import sys

from pyros1.cli.commands.pkg._files import files_verb, folder_of, home_of_packages
from pyros1.cli.records import Argument


def _ls(words: list[str]) -> int:
    options = [word for word in words if word.startswith("-")]
    places = [word for word in words if not word.startswith("-")]
    paths = [folder_of(place) for place in places] or [home_of_packages()]
    sys.stdout.flush()
    return subprocess.run(["ls", *options, *paths], check=False).returncode


VERB = files_verb(
    "ls",
    "rosls",
    _ls,
    Argument("package[/folder]", "package|place", optional=True),
    about="list a package's folder",
    examples=[("roscpp", "the content of its folder"), ("-l roscpp/srv", "one of its subfolders, with options of ls")],
)
