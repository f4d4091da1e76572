"""``pyros1 launch -c NAME -u URI --run_id ID``: what a stock launcher starts on other machines (L151-L153)."""

from __future__ import annotations

import sys
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.ground.errors import Error
from pyros1.launch.reading.world import make_resources
from pyros1.launch.remote.child import Child, end_with_stdin
from pyros1.launch.running.options import Options
from pyros1.launch.running.supervisor import install_signals


def run_child(values: Any, words: list[str]) -> int:
    """Serve the parent until the launch ends.

    Args:
        values: values of the options.
        words: the other words on the command line.

    Returns:
        The exit code: 1 if the parent cannot be served.
    """
    for option in ("server_uri", "run_id"):
        if not getattr(values, option):
            raise UsageError(f"--child option requires --{option} to be set as well")
    if words:
        raise UsageError("Input files are not allowed when run in child mode")
    screen = False if values.force_log else True if values.force_screen else None
    options = Options(
        screen=screen,
        required=values.force_required,
        sigint_timeout=values.sigint_timeout,
        sigterm_timeout=values.sigterm_timeout,
    )
    try:
        child = Child(values.child_name, values.server_uri, values.run_id, options, make_resources())
        restore = install_signals(child.stop, child.stop_waiting)
        end_with_stdin(child.stop)
        try:
            child.run()
        finally:
            restore()
    except Error as error:
        print(f"RLException: {error}", file=sys.stderr)
        return 1
    return 0
