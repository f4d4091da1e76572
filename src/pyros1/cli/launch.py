"""``pyros1 launch``: start what launch files describe (https://wiki.ros.org/roslaunch/Commandline%20Tools)."""

from __future__ import annotations

import os
import re
import sys
from optparse import OptionParser, Values
from pathlib import Path

from pyros1.cli.launch_options import EXCLUSIVE, QUERIES, TOOLS, make_parser
from pyros1.errors import Error, LaunchError, PackageNotFoundError
from pyros1.launch.command_line import OWN_PACKAGES
from pyros1.launch.loader import STDIN, absolute_files, load_plan
from pyros1.launch.places import package_index
from pyros1.launch.plan import Plan
from pyros1.launch.resources import Resources
from pyros1.launch.suggest import did_you_mean

_ARGUMENT = re.compile(r"[A-Za-z~/_][\w/]*:=.*")
_COMMAND_TIMEOUT_S = 600.0


def main(argv: list[str]) -> int:
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
    if options.child_name or options.server_uri:
        parser.error("remote child mode (-c, -u) is not available")
    late = [option for option, name in TOOLS.items() if getattr(options, f"tool_{name}")]
    if late:
        parser.error(f"{late[0]} must be the first word")
    if sum(bool(getattr(options, name)) for name in EXCLUSIVE) > 1:
        parser.error("only one of --nodes, --find-node, --args and --ros-args can be given")
    if not words and not options.core:
        parser.error("you must specify at least one input file")
    if options.core and words:
        parser.error("input files are not allowed in core mode")
    resources = make_resources()
    try:
        if options.check and (options.output_file or any(map(os.path.isdir, words))):
            from pyros1.cli.launch_tools import check_package_files  # noqa: PLC0415 - each start imports what it needs

            return check_package_files(words, arguments, options, parser)
        files = find_files(words, resources, parser)
        if options.check:
            from pyros1.cli.launch_queries import check  # noqa: PLC0415

            return check(files, arguments, resources)
        if any(getattr(options, name) for name in QUERIES):
            from pyros1.cli.launch_queries import answer  # noqa: PLC0415

            return answer(files, arguments, resources, options)
        plan = _load(files, arguments, resources, options)
        return launch(plan, options, resources, title=",".join(os.path.basename(file) for file in files) or "roscore")
    except Error as error:
        print_exception(error)
        return 1


def parse_arguments(argv: list[str]) -> dict[str, str]:
    """Return the ``name:=value`` words of a command line (X03).

    A name without a value, and ``_name``, which is a parameter of a node, say nothing; what has a second ``:=`` is
    reported and says nothing either.
    """
    arguments: dict[str, str] = {}
    for word in argv:
        if not _ARGUMENT.fullmatch(word):
            continue
        name, value, *more = (part.strip() for part in word.split(":="))
        if more:
            print(f"ERROR: Invalid remapping argument '{word}'", file=sys.stderr)
        elif value and (not name.startswith("_") or name.startswith("__") or name == "_"):
            arguments[name] = value
    return arguments


def make_resources() -> Resources:
    """Return the real world for `load_plan`."""
    return Resources(
        packages=package_index(os.environ),
        environ=os.environ,
        run_command=_run_command,
        unique=_unique,
        stdin=sys.stdin.read,
    )


def _unique() -> str:
    # Rarely needed.
    import random  # noqa: PLC0415
    import socket  # noqa: PLC0415

    return f"{socket.gethostname()}_{os.getpid()}_{random.randrange(10**18)}"


def _run_command(words: list[str]) -> str:
    # Rarely needed when only a question is asked.
    import subprocess  # noqa: PLC0415

    from pyros1.launch.command_line import own_python_environment  # noqa: PLC0415
    from pyros1.launch.xacro_tool import xacro_words  # noqa: PLC0415

    command = xacro_words(words)
    env = {**os.environ, **own_python_environment(os.environ)} if command is not words else None
    try:
        done = subprocess.run(command, env=env, stdout=subprocess.PIPE, check=False, timeout=_COMMAND_TIMEOUT_S)
    except FileNotFoundError as error:
        raise LaunchError(f"no such command [{words}].") from error
    except (OSError, subprocess.TimeoutExpired) as error:
        raise LaunchError(f"command [{words}] failed: {error}") from error
    if done.returncode:
        raise LaunchError(f"command [{words}] returned with code [{done.returncode}].")
    return done.stdout.decode("utf-8", "replace")


def find_files(words: list[str], resources: Resources, parser: OptionParser) -> list[str]:
    """Turn ``pkg file``, ``file...`` and ``-`` into paths (X01, X05).

    A bare file name that is not in the current folder may also be that of one of pyros1's own launch files.
    """
    if words.count(STDIN) > 1:
        parser.error("Only a single instance of the dash ('-') may be specified.")
    if len(words) > 1 and words[0] != STDIN:
        found = _in_package(words[0], words[1], resources)
        if found:
            words = [found, *words[2:]]
        elif not os.path.isfile(words[0]):
            package, file = words[:2]
            hint = "" if _is_package(package, resources) else f": there is no package [{package}]"
            hint += did_you_mean(package, resources.packages.list()) if hint else ""
            raise LaunchError(
                f"[{file}] is neither a launch file in package [{package}] nor is [{package}] a launch file name{hint}"
            )
    if len(words) == 1 and words[0] != STDIN and not os.path.isfile(words[0]):
        own = _own_file(words[0])
        if own is None:
            raise LaunchError(f"[{words[0]}] is not a launch file name{resources.near_file(words[0])}")
        return [own]
    missing = [word for word in words if word != STDIN and not os.path.exists(word)]
    if missing:
        parser.error(f"The following input files do not exist: {', '.join(missing)}")
    return words


def _is_package(name: str, resources: Resources) -> bool:
    try:
        resources.packages.find(name)
    except PackageNotFoundError:
        return False
    return True


def _in_package(package: str, file: str, resources: Resources) -> str | None:
    try:
        found = resources.packages.find_resource(package, file)
    except PackageNotFoundError:
        return None
    if len(found) > 1:
        places = "\n".join(f" * {path}" for path in found)
        raise LaunchError(
            f"multiple files named [{file}] in package [{package}]:\n{places}\nPlease specify full path instead"
        )
    return str(found[0]) if found else None


def _own_file(name: str) -> str | None:
    if os.path.dirname(name):
        return None
    found = sorted(path for path in OWN_PACKAGES.glob(f"*/launch/{re.sub(r'[*?[]', '', name)}") if path.is_file())
    return str(found[0]) if found else None


def _load(files: list[str], arguments: dict[str, str], resources: Resources, options: Values) -> Plan:
    plan = load_plan(files, arguments, resources)
    if options.verbose:
        for file in absolute_files(plan.files):
            print(f"... loaded [{file}]")
    return plan


def launch(plan: Plan, values: Values, resources: Resources, *, title: str) -> int:
    """Run a plan until it is over.

    Args:
        plan: what to launch.
        values: options as parsed.
        resources: for the executables.
        title: of the terminal.
    """
    # Everything below is needed only when something is really launched.
    from pyros1.launch.check import check_machines  # noqa: PLC0415
    from pyros1.launch.console import Console  # noqa: PLC0415
    from pyros1.launch.options import Options  # noqa: PLC0415
    from pyros1.launch.session import Session  # noqa: PLC0415
    from pyros1.launch.supervisor import install_signals  # noqa: PLC0415

    check_machines(plan)
    screen = True if values.force_screen else False if values.force_log else None
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
    )
    console = Console(title=options.show_title)
    session = Session(plan, options, resources.packages, resources.environ, console)
    pid_file = Path(values.pid_file) if values.pid_file else None
    if pid_file is not None:
        _write_pid(pid_file)
    restore = install_signals(session.stop)
    try:
        session.run()
    finally:
        restore()
        if pid_file is not None:
            pid_file.unlink(missing_ok=True)
    return session.exit_code


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

    sys.exit(entry(["pyros1", "launch", *sys.argv[1:]]))
