"""Clear errors for names that stock's modules have and ours lack."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def missing(module: str, **reasons: str) -> Callable[[str], Any]:
    """Return a module's ``__getattr__``, which says that pyros1 lacks a name.

    Args:
        module: the module's full name.
        **reasons: for names that programs may look for, why they are not here, or what does their work.
    """

    def __getattr__(name: str) -> Any:
        reason = reasons.get(name)
        raise AttributeError(f"pyros1 has no {module}.{name}" + (f": {reason}" if reason else ""))

    return __getattr__
