"""Our modules that need no node, imported under their own names for a test, and forgotten after it."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

from pyros1.drop_in.finder import MODULES_FOLDER


@contextmanager
def imported(name: str) -> Iterator[ModuleType]:
    """Import a module of ours."""
    sys.path.insert(0, MODULES_FOLDER)
    try:
        yield importlib.import_module(name)
    finally:
        sys.path.remove(MODULES_FOLDER)
        top = name.partition(".")[0]
        for each in [each for each in sys.modules if each.partition(".")[0] == top]:
            del sys.modules[each]
