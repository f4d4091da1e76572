"""Speeds up imports by disabling garbage collection, which is useless then since the objects in modules stay alive."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def loading() -> Iterator[None]:
    """Disable garbage collection in a block of imports, which makes the imports 10 % faster; then move all objects to
    the oldest generation.

    The block must not wait for anything, since garbage collection is also disabled for the program's other threads.
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if not gc.get_freeze_count():  # otherwise the program has frozen objects, which must stay frozen
            gc.freeze()
            gc.unfreeze()  # moves all objects to the oldest generation, which the next collections will not visit
        if was_enabled:
            gc.enable()
