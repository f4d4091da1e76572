"""Shared code of ``launch``, ``core`` and ``test``: runs a plan and prints errors."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pyros1.cli.failures import UsageError
from pyros1.cli.shared.integers import PORT_RANGE
from pyros1.ground.errors import Error, LaunchError

if TYPE_CHECKING:
    from pyros1.launch.plan import Plan
    from pyros1.launch.reading.resources import Resources


def launch(plan: Plan, parsed_options: Any, resources: Resources, *, title: str) -> int:
    """Run a plan until all its nodes have exited or it is stopped. Return the exit code.

    Args:
        plan: the plan to launch.
        parsed_options: the parsed options of ``launch``.
        resources: the environment and packages, which are used to find executables.
        title: the title to give the terminal.

    Raises:
        UsageError: this system does not support an option.
        LaunchError: the value of an option is out of range, or the plan cannot be run.
    """
    # These are only needed for a launch.
    from pyros1.launch.running.check import check_machines, is_remote  # noqa: PLC0415
    from pyros1.launch.running.console import Console  # noqa: PLC0415
    from pyros1.launch.running.core import LOG_LEVELS  # noqa: PLC0415
    from pyros1.launch.running.options import Options  # noqa: PLC0415
    from pyros1.launch.running.session import Session  # noqa: PLC0415
    from pyros1.launch.running.supervisor import install_signals  # noqa: PLC0415

    _check_option_values(parsed_options)
    check_machines(plan)
    if getattr(parsed_options, "preload", False) and not hasattr(os, "fork"):
        raise UsageError("--preload needs fork, which this system does not have")
    if parsed_options.local_only:
        print("local only launch specified, will not launch remote nodes")
        plan = replace(plan, nodes=[node for node in plan.nodes if not is_remote(plan, node)])
    level = parsed_options.master_logger_level.lower() or "info"
    if level not in LOG_LEVELS:
        print(f"WARNING: --master-logger-level: unknown level {level!r}", file=sys.stderr)
        level = "info"
    # As in stock ROS, the output is written to log files if both options are given.
    to_screen = False if parsed_options.force_log else True if parsed_options.force_screen else None
    options = Options(
        core=parsed_options.core,
        port=parsed_options.port,
        run_id=parsed_options.run_id,
        screen=to_screen,
        required=parsed_options.force_required,
        local=parsed_options.local_only,
        wait=parsed_options.wait_for_master,
        show_summary=not parsed_options.no_summary,
        sigint_timeout=parsed_options.sigint_timeout,
        sigterm_timeout=parsed_options.sigterm_timeout,
        title=title,
        notify_timeout=parsed_options.timeout,
        prefix=parsed_options.prefix,
        master_log_level=level,
        preload=getattr(parsed_options, "preload", False),
        journal=parsed_options.core and not getattr(parsed_options, "no_journal", False),
    )
    console = Console(title=not parsed_options.disable_title)
    session = Session(plan, options, resources.packages, resources.environ, console)
    pid_file = Path(parsed_options.pid_file) if parsed_options.pid_file else None
    if pid_file is not None:
        _write_pid(pid_file)
    restore_signals = install_signals(session.stop, session.stop_waiting)
    try:
        session.run()
    finally:
        restore_signals()
        if pid_file is not None:
            pid_file.unlink(missing_ok=True)
    return session.exit_code


def _check_option_values(parsed_options: Any) -> None:
    if parsed_options.port is not None and parsed_options.port not in PORT_RANGE[1:]:
        raise LaunchError(f"the port must be from 1 to 65535, not {parsed_options.port}")
    for name in ("sigint_timeout", "sigterm_timeout", "timeout"):
        seconds = getattr(parsed_options, name)
        if seconds is not None and not seconds > 0:
            raise LaunchError(f"{name} must be a positive number, received {seconds:f}")


def _write_pid(path: Path) -> None:
    try:
        path.write_text(str(os.getpid()), encoding="ascii")
    except OSError as error:
        raise LaunchError(f"cannot write the pid file {path}: {error.strerror}") from error


def print_exception(error: Error) -> None:
    """Print why nothing was launched, in the format of stock ROS, since scripts search for it."""
    red, reset = ("\033[31m", "\033[0m") if sys.stderr.isatty() else ("", "")
    print(f"{red}RLException: {error}{reset}", file=sys.stderr)
