"""The ``pyros1`` program. Before it loads anything else, it makes Ctrl-C end the process quietly."""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]  # the part of `signal` that Python always loads
import sys


def entry(argv: list[str] | None = None, *, alone: bool | None = None) -> int:
    """Run a command.

    Commands that run until Ctrl-C exit with code 0. Other commands are killed by Ctrl-C's signal, SIGINT, so that a
    shell loop around them stops as well.

    Args:
        argv: the command line, including the program's name; None for ``sys.argv``. If the name is a stock tool's, such
            as ``rostopic``, the program acts as that tool.
        alone: whether this process exists only to run the command; by default, whether `argv` is None.

    Returns:
        The exit code.
    """
    if alone is None:
        alone = argv is None
    if alone:
        exit_quietly_on_sigint()
    from pyros1.cli.dispatch import dispatch  # noqa: PLC0415 - a traceback from imports would be useless

    return dispatch(sys.argv if argv is None else argv, alone)


def run_script(file: str) -> None:
    """Run the command for a script in one of pyros1's ROS packages with this process's arguments, and end the process.

    Args:
        file: the script, or a link to it.
    """
    exit_quietly_on_sigint()
    from pyros1.cli.package_scripts import run  # noqa: PLC0415 - as above

    run(file)


def exit_quietly_on_sigint() -> None:
    """Let SIGINT end the process at once instead of raising KeyboardInterrupt, until a command can act on it."""
    if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)
