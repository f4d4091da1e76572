"""``pyros1 launch``: start what launch files describe (https://wiki.ros.org/roslaunch/Commandline%20Tools)."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from optparse import Values
from pathlib import Path
from typing import TYPE_CHECKING

from pyros1.cli.launch_options import EXCLUSIVE, QUERIES, TOOLS, make_parser
from pyros1.errors import Error, LaunchError
from pyros1.launch.words import WordsError, find_files, parse_arguments

if TYPE_CHECKING:
    from pyros1.launch.plan import Plan
    from pyros1.launch.resources import Resources


def main(argv: list[str]) -> int:  # noqa: PLR0911 - one way out per kind of run
    """Run ``pyros1 launch``.

    Args:
        argv: the words after the command's name.

    Returns:
        The exit code: 0, also when nodes died; 1 when a required node failed or nothing could be launched; 2 for a
        wrong command line.
    """
    if argv and argv[0] in TOOLS:
        from pyros1.cli import launch_tools  # noqa: PLC0415 - each start imports what it needs

        tool: int = getattr(launch_tools, TOOLS[argv[0]])(argv[1:])
        return tool
    parser = make_parser()
    arguments = parse_arguments(argv)
    options, words = parser.parse_args([word for word in argv if ":=" not in word])
    if options.child_name:
        from pyros1.cli.launch_child import run_child  # noqa: PLC0415 - each start imports what it needs

        return run_child(options, words, parser)
    late = [option for option, name in TOOLS.items() if getattr(options, f"tool_{name}")]
    if late:
        parser.error(f"{late[0]} must be the first word")
    if sum(bool(getattr(options, name)) for name in EXCLUSIVE) > 1:
        parser.error("only one of --nodes, --find-node, --args and --ros-args can be given")
    if not words and not options.core:
        parser.error("you must specify at least one input file")
    if options.core and words:
        parser.error("input files are not allowed in core mode")
    # Help and wrong command lines need none of what follows.
    from pyros1.launch.loader import load_plan  # noqa: PLC0415
    from pyros1.launch.world import make_resources  # noqa: PLC0415

    resources = make_resources()
    try:
        if options.check and (options.output_file or any(map(os.path.isdir, words))):
            from pyros1.cli.launch_tools import check_package_files  # noqa: PLC0415 - each start imports what it needs

            return check_package_files(words, arguments, options, parser)
        files = find_files(words, resources)
        if options.check:
            from pyros1.cli.launch_queries import check  # noqa: PLC0415

            return check(files, arguments, resources)
        if any(getattr(options, name) for name in QUERIES):
            from pyros1.cli.launch_queries import answer  # noqa: PLC0415

            return answer(files, arguments, resources, options)
        plan = load_plan(files, arguments, resources)
        if options.verbose:
            from pyros1.launch.report import contents  # noqa: PLC0415

            print(contents(plan))
        return launch(plan, options, resources, title=",".join(os.path.basename(file) for file in files) or "roscore")
    except WordsError as error:
        parser.error(str(error))
    except Error as error:
        print_exception(error)
        return 1


def launch(plan: Plan, values: Values, resources: Resources, *, title: str) -> int:
    """Run a plan until it is over.

    Args:
        plan: what to launch.
        values: options as parsed.
        resources: for the executables.
        title: of the terminal.
    """
    # Everything below is needed only when something is really launched.
    from pyros1.launch.check import check_machines, is_remote  # noqa: PLC0415
    from pyros1.launch.console import Console  # noqa: PLC0415
    from pyros1.launch.core import LOG_LEVELS  # noqa: PLC0415
    from pyros1.launch.options import Options  # noqa: PLC0415
    from pyros1.launch.session import Session  # noqa: PLC0415
    from pyros1.launch.supervisor import install_signals  # noqa: PLC0415

    _check_numbers(values)
    check_machines(plan)
    if values.local_only:
        print("local only launch specified, will not launch remote nodes")
        plan = replace(plan, nodes=[node for node in plan.nodes if not is_remote(plan, node)])
    level = values.master_logger_level.lower() or "info"
    if level not in LOG_LEVELS:
        print(f"WARNING: --master-logger-level: there is no level {level!r}", file=sys.stderr)
        level = "info"
    # As stock: whoever says both gets log files.
    screen = False if values.force_log else True if values.force_screen else None
    options = Options(
        core=values.core,
        port=values.port,
        run_id=values.run_id,
        screen=screen,
        required=values.force_required,
        local=values.local_only,
        wait=values.wait_for_master,
        show_summary=not values.no_summary,
        show_title=not values.disable_title,
        sigint_timeout=values.sigint_timeout,
        sigterm_timeout=values.sigterm_timeout,
        title=title,
        notify_timeout=values.timeout,
        prefix=values.prefix,
        master_log_level=level,
    )
    console = Console(title=options.show_title)
    session = Session(plan, options, resources.packages, resources.environ, console)
    pid_file = Path(values.pid_file) if values.pid_file else None
    if pid_file is not None:
        _write_pid(pid_file)
    restore = install_signals(session.stop, session.hurry)
    try:
        session.run()
    finally:
        restore()
        if pid_file is not None:
            pid_file.unlink(missing_ok=True)
    return session.exit_code


def _check_numbers(values: Values) -> None:
    for name in ("sigint_timeout", "sigterm_timeout", "timeout"):
        seconds = getattr(values, name)
        if seconds is not None and not seconds > 0:
            raise LaunchError(f"{name} must be a positive number, received {seconds:f}")


def _write_pid(path: Path) -> None:
    try:
        path.write_text(str(os.getpid()), encoding="ascii")
    except OSError as error:
        raise LaunchError(f"cannot write the pid file {path}: {error.strerror}") from error


def print_exception(error: Error) -> None:
    """Print why nothing was launched, in the words that scripts look for."""
    red, off = ("\033[31m", "\033[0m") if sys.stderr.isatty() else ("", "")
    print(f"{red}RLException: {error}{off}", file=sys.stderr)


if __name__ == "__main__":
    from pyros1.cli.main import entry

    sys.exit(entry(["pyros1", "launch", *sys.argv[1:]], alone=True))
