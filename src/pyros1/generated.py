"""The import hook for ``pyros1.msgs.<package>``, whose modules are made of definitions (`pyros1.finding.importing`).

It loads what makes them when the first is imported: most programs that import pyros1 need it, most commands do not.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

PREFIX = "pyros1.msgs"


def finder() -> Any:
    """Return the process's :class:`pyros1.finding.importing.MessageFinder`.

    An import statement has no place for arguments: where definitions are, the process's own environment decides.
    """
    return import_module("pyros1.finding.importing").installed(os.environ)


class Hook:
    """Finds modules of messages and services."""

    @staticmethod
    def find_spec(name: str, path: Sequence[str] | None = None, target: ModuleType | None = None) -> ModuleSpec | None:
        """Answer the import system; see `pyros1.finding.importing.MessageFinder.find_spec`."""
        if not name.startswith(PREFIX + "."):
            return None
        if Hook in sys.meta_path:
            sys.meta_path.remove(Hook)  # the finder takes its place
        found: ModuleSpec | None = finder().find_spec(name, path, target)
        return found


def install() -> None:
    """Install the hook, once."""
    if Hook not in sys.meta_path:
        sys.meta_path.append(Hook)
