"""Ctrl-C while a program is still starting: it ends the program, without a traceback of imports.

Imported before everything else, so it imports only modules that Python has already loaded.
"""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]  # the part of `signal` that costs nothing
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import TracebackType


def prepare() -> None:
    """Let SIGINT end a starting program quietly.

    Our commands have no handler until they can act on the signal. A user's program keeps its handler, so it can catch
    KeyboardInterrupt; an uncaught one that came from an import is not printed.
    """
    words = getattr(sys, "argv", None) or [""]
    if words[0].endswith("/bin/pyros1"):
        if callable(_signal.getsignal(_signal.SIGINT)):  # otherwise it is ignored, or ends the program anyway
            _signal.signal(_signal.SIGINT, _signal.SIG_DFL)
    elif sys.excepthook is sys.__excepthook__:
        sys.excepthook = _hook


def _hook(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    if issubclass(kind, KeyboardInterrupt) and _is_starting(trace) and not hasattr(sys, "ps1"):
        import os  # noqa: PLC0415 - only now

        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)
        os.kill(os.getpid(), _signal.SIGINT)
    sys.__excepthook__(kind, error, trace)


def _is_starting(trace: TracebackType | None) -> bool:
    """Return whether a traceback comes from an import, or from the creation of a node."""
    while trace is not None:
        code = trace.tb_frame.f_code
        if code.co_filename.startswith("<frozen importlib"):
            return True
        if code.co_name == "<module>" and trace.tb_frame.f_globals.get("__name__") != "__main__":
            return True
        if code.co_name == "__init__" and code.co_filename.endswith("/pyros1/node/node.py"):
            return True
        trace = trace.tb_next
    return False
