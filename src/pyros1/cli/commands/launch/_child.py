"""``pyros1 launch -c NAME -u URI --run_id ID``: runs as the child of a remote stock launcher (L151-L153)."""

from __future__ import annotations

import sys
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.ground.errors import Error
from pyros1.launch.reading.system_resources import make_resources
from pyros1.launch.remote.child import Child, stop_when_stdin_closes
from pyros1.launch.running.options import Options
from pyros1.launch.running.supervisor import install_signals


def run_child(parsed_options: Any, args: list[str]) -> int:
    """Serve the parent launcher until the launch ends.

    Args:
        parsed_options: the parsed options.
        args: the positional arguments.

    Returns:
        The exit code: 1 if the parent cannot be served, otherwise 0.

    Raises:
        UsageError: a required option is missing, or files are given.
    """
    for option in ("server_uri", "run_id"):
        if not getattr(parsed_options, option):
            raise UsageError(f"--child option requires --{option} to be set as well")
    if args:
        raise UsageError("Input files are not allowed when run in child mode")
    to_screen = False if parsed_options.force_log else True if parsed_options.force_screen else None
    options = Options(
        screen=to_screen,
        required=parsed_options.force_required,
        sigint_timeout=parsed_options.sigint_timeout,
        sigterm_timeout=parsed_options.sigterm_timeout,
    )
    try:
        child = Child(
            parsed_options.child_name, parsed_options.server_uri, parsed_options.run_id, options, make_resources()
        )
        restore_signals = install_signals(child.stop, child.stop_waiting)
        stop_when_stdin_closes(child.stop)
        try:
            child.run()
        finally:
            restore_signals()
    except Error as error:
        print(f"RLException: {error}", file=sys.stderr)
        return 1
    return 0
