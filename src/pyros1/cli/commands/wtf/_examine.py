"""The work of ``pyros1 wtf``: collect facts, check them, print what is wrong."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from pyros1 import __version__
from pyros1.cli.packages_here import packages_around
from pyros1.cli.shared.printing import use_colour
from pyros1.doctor.facts import Machine, System
from pyros1.doctor.finding import ERROR, WARNING, Finding
from pyros1.doctor.local_facts import check_packages, collect_machine
from pyros1.doctor.machine_checks import check_machine
from pyros1.doctor.reach_checks import check_reach
from pyros1.doctor.system import collect_system
from pyros1.doctor.topic_checks import check_topics
from pyros1.ground.errors import DeadlineError, Error, MasterUnreachableError
from pyros1.ground.terminal_text import one_line
from pyros1.net.hosts import is_local, master_uri, parse_uri
from pyros1.net.master_client import MasterClient

_RULE = "=" * 80
MASTER_TIMEOUT = 3.0
"""Timeout for the master's first answer in seconds."""


@dataclass
class Examined:
    """The findings, and the facts that they are based on; see `pyros1.doctor`."""

    machine: Machine
    findings: list[Finding]
    system: System | None = None
    types: dict[str, str] = field(default_factory=dict)


def examine(everything: bool, offline: bool, quiet: bool, files: list[str], words: list[str]) -> Examined:
    """Collect, check and print.

    Args:
        everything: also check all packages.
        offline: do not check the running system.
        quiet: print nothing.
        files: launch files.
        words: the command line's words, with ``name:=value`` for the files.
    """

    def say(text: str) -> None:
        if not quiet:
            print(text, flush=True)

    def summary(title: str, findings: list[Finding]) -> None:
        if not quiet:
            print_findings(title, findings)

    say(_introduction(everything, files))
    machine = collect_machine(os.environ)
    machine.launch_problems = _launch_problems(files, words)
    machine.package_problems = check_packages(os.environ) if everything else []
    static = check_machine(machine)
    say(_RULE)
    summary("Static checks summary:", static)
    say(_RULE)
    if offline:
        say("\nOnline graph checks will not be run.")
        return Examined(machine, static)
    master, unreachable = _master()
    if master is None:
        state = "does not answer" if unreachable else "does not appear to be running"
        say(f"\nROS Master {state}.\nOnline graph checks will not be run.")
        say(f"ROS_MASTER_URI is [{master_uri(os.environ, {})}]")
        missing = _unresponsive_master() if unreachable else _no_master(machine)
        if not quiet:
            print(f"  cure: {missing.cure}")
        return Examined(machine, [*static, missing])
    system, types = None, {}
    try:
        say("Beginning tests of your ROS graph. These may take a while...\nanalyzing graph...")
        system = collect_system(master)
        types = {str(topic): str(name) for topic, name in master.get_topic_types()}
        say("... done analyzing graph\nrunning graph rules...")
        online = [*check_reach(system, machine), *check_topics(system)]
        say("... done running graph rules\n")
    except Error as error:
        online = [
            Finding(
                "master",
                ERROR,
                f"the master gives unexpected answers: {error}",
                "if ROS_MASTER_URI is right, another program may be using the port: stop it and start pyros1 core",
            )
        ]
    finally:
        master.close()
    summary("Online checks summary:", online)
    return Examined(machine, [*static, *online], system, types)


def report_of(examined: Examined) -> str:
    """Return a report for people who can help, as Markdown."""
    from pyros1.doctor.report import report, versions  # noqa: PLC0415 - only needed for reports

    place = "a virtual environment" if sys.prefix != sys.base_prefix else "the system's Python"
    about = {
        "pyros1": f"{__version__}, in {Path(__file__).parents[3]}",
        "Python": f"{sys.version.split()[0]} ({platform.python_implementation()}), {place}, {sys.executable}",
        "system": f"{platform.platform()}, {platform.machine()}",
        "stock ROS": ", ".join(str(each) for each in sorted(Path("/opt/ros").glob("*"))) or "not in /opt/ros",
        "libraries": ", ".join(f"{name} {version}" for name, version in versions().items()),
    }
    around = packages_around(os.getcwd())
    if around:
        about["packages around this folder"] = f"{', '.join(around)}; pyros1 itself adds them to ROS_PACKAGE_PATH"
    return report(about, examined.machine, examined.system, examined.types, examined.findings)


def _introduction(everything: bool, files: Iterable[str]) -> str:
    if files:
        return f"Launch files: {', '.join(files)}"
    folder = next((each for each in (Path.cwd(), *Path.cwd().parents) if (each / "package.xml").is_file()), None)
    location = f"Package: {folder.name}" if folder else "No package or stack in the current directory"
    return f"{location}\nroswtf will run against all packages" if everything else location


def _launch_problems(files: list[str], words: list[str]) -> list[str]:
    """Return the problems that `launch --check` reports about the files."""
    if not files:
        return []
    from pyros1.ground.errors import LaunchError  # noqa: PLC0415 - only with launch files
    from pyros1.launch.reading.loader import load_plan  # noqa: PLC0415
    from pyros1.launch.reading.words import find_files, parse_arguments  # noqa: PLC0415
    from pyros1.launch.reading.world import make_resources  # noqa: PLC0415
    from pyros1.launch.running.check import missing_parts  # noqa: PLC0415

    resources = make_resources()
    problems: list[LaunchError] = []
    texts: list[str] = []
    try:
        plan = load_plan(find_files(files, resources), parse_arguments(words), resources, problems=problems)
        texts = [*plan.warnings, *map(str, missing_parts(plan, resources.packages, resources.environ))]
    except Error as error:
        texts = [str(error)]
    return [*map(str, problems), *texts]


def _master() -> tuple[MasterClient | None, bool]:
    """Return the master, None if it does not answer; then also whether a timeout was the reason."""
    try:
        master = MasterClient("/roswtf", master_uri(os.environ, {}), timeout=MASTER_TIMEOUT)
    except Error:
        return None, False  # the URI is wrong, which the static checks have reported
    try:
        master.ping()
    except MasterUnreachableError as error:
        master.close()
        return None, isinstance(error.__cause__, DeadlineError)
    return master, False


def _unresponsive_master() -> Finding:
    return Finding(
        "silent-master",
        ERROR,
        f"the master at {master_uri(os.environ, {})} did not answer within {MASTER_TIMEOUT:g} s",
        "if its process is suspended, continue it with kill -CONT; if it hangs, stop it and start pyros1 core; "
        "if it is on another machine, check the network and its firewall",
    )


def _no_master(machine: Machine) -> Finding:
    uri = master_uri(os.environ, {})
    try:
        host, _ = parse_uri(uri)
        location = is_local(host)
    except Error:
        location = True
    if location:
        others = [each for each in machine.masters if each.rstrip("/") != uri.rstrip("/")]
        cure = f"pyros1 core{f', or export ROS_MASTER_URI={others[0]}: a master is running there' if others else ''}"
        return Finding("no-master", WARNING, f"no master answers at {uri}", cure)
    return Finding(
        "no-master",
        ERROR,
        f"no master answers at {uri}",
        f"check that ROS_MASTER_URI is right, that {host} can be reached (ping {host}), that a master is running "
        "there, and that no firewall blocks it",
    )


def print_findings(title: str, findings: list[Finding]) -> None:
    """Print a summary of findings, like the stock tool, with their fixes."""
    print(title)
    colour = use_colour(sys.stdout)
    for severity, about, mark in (
        (WARNING, "Warnings are things that may be just fine, but are sometimes at fault\n", "\x1b[1m"),
        (ERROR, "", "\x1b[31m\x1b[1m"),
    ):
        some = [finding for finding in findings if finding.severity == severity]
        if not some:
            continue
        print(f"\nFound {len(some)} {severity}(s).\n{about}")
        for finding in some:
            word = f"{mark}{severity.upper()}\x1b[0m" if colour else severity.upper()
            print(f"{word} {one_line(finding.text)}", *(f" * {one_line(item)}" for item in finding.items), sep="\n")
            print(f"   cure: {one_line(finding.cure)}\n")
    if not findings:
        print(f"\nNo errors or warnings (pyros1 {__version__}, Python {sys.version.split()[0]})\n")
    sys.stdout.flush()
