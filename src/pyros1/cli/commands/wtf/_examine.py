"""Collects facts for ``pyros1 wtf``, checks them and prints the problems."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from pyros1 import __version__
from pyros1.cli.nearby_packages import find_nearby_packages
from pyros1.cli.shared.printing import should_use_colour
from pyros1.doctor.bridge_checks import check_bridges
from pyros1.doctor.connectivity_checks import check_connectivity
from pyros1.doctor.facts import Machine, System
from pyros1.doctor.finding import ERROR, WARNING, Finding
from pyros1.doctor.local_facts import check_packages, collect_machine
from pyros1.doctor.machine_checks import check_machine
from pyros1.doctor.system import collect_system
from pyros1.doctor.topic_checks import check_topics
from pyros1.ground.errors import DeadlineError, Error, MasterUnreachableError
from pyros1.ground.terminal_text import one_line
from pyros1.net.hosts import is_local, master_uri, parse_uri
from pyros1.net.master_client import MasterClient

_SEPARATOR = "=" * 80
MASTER_TIMEOUT = 3.0
"""Timeout for the master's first response in seconds."""


@dataclass
class Examination:
    """The findings, and the facts on which they are based. See `pyros1.doctor`."""

    machine: Machine
    findings: list[Finding]
    system: System | None = None
    types: dict[str, str] = field(default_factory=dict)


def examine(checks_packages: bool, offline: bool, quiet: bool, files: list[str], args: list[str]) -> Examination:
    """Collect facts, check them, and print what is found. Return the facts and the findings.

    Args:
        checks_packages: whether to check all packages as well.
        offline: whether to skip the checks of the running system.
        quiet: whether to print nothing.
        files: the launch files.
        args: the command's arguments, including ``name:=value`` for the files.
    """

    def print_line(text: str) -> None:
        if not quiet:
            print(text, flush=True)

    def print_summary(title: str, findings: list[Finding]) -> None:
        if not quiet:
            print_findings(title, findings)

    print_line(_introduction_text(checks_packages, files))
    machine = collect_machine(os.environ)
    machine.launch_problems = _launch_problems(files, args)
    machine.package_problems = check_packages(os.environ) if checks_packages else []
    static_findings = check_machine(machine)
    print_line(_SEPARATOR)
    print_summary("Static checks summary:", static_findings)
    print_line(_SEPARATOR)
    if offline:
        print_line("\nOnline graph checks will not be run.")
        return Examination(machine, static_findings)
    master, has_timed_out = _connect_to_master()
    if master is None:
        state_text = "does not answer" if has_timed_out else "does not appear to be running"
        print_line(f"\nROS Master {state_text}.\nOnline graph checks will not be run.")
        print_line(f"ROS_MASTER_URI is [{master_uri(os.environ, {})}]")
        finding = _unresponsive_master_finding() if has_timed_out else _no_master_finding(machine)
        if not quiet:
            print(f"  fix: {finding.fix}")
        return Examination(machine, [*static_findings, finding])
    system, types = None, {}
    try:
        print_line("Beginning tests of your ROS graph. These may take a while...\nanalyzing graph...")
        system = collect_system(master)
        types = {str(topic): str(name) for topic, name in master.get_topic_types()}
        print_line("... done analyzing graph\nrunning graph rules...")
        online_findings = [*check_connectivity(system, machine), *check_topics(system), *check_bridges(system)]
        print_line("... done running graph rules\n")
    except Error as error:
        online_findings = [
            Finding(
                "master",
                ERROR,
                f"the master sends unexpected responses: {error}",
                "if ROS_MASTER_URI is correct, another program may be using the port: stop it and start pyros1 core",
            )
        ]
    finally:
        master.close()
    print_summary("Online checks summary:", online_findings)
    return Examination(machine, [*static_findings, *online_findings], system, types)


def make_report(examination: Examination) -> str:
    """Return a Markdown report that users can include in questions and issues."""
    from pyros1.doctor.report import format_report, versions  # noqa: PLC0415 - only needed for reports

    environment = "a virtual environment" if sys.prefix != sys.base_prefix else "the system's Python"
    facts = {
        "pyros1": f"{__version__}, in {Path(__file__).parents[3]}",
        "Python": f"{sys.version.split()[0]} ({platform.python_implementation()}), {environment}, {sys.executable}",
        "system": f"{platform.platform()}, {platform.machine()}",
        "stock ROS": ", ".join(str(folder) for folder in sorted(Path("/opt/ros").glob("*"))) or "not in /opt/ros",
        "libraries": ", ".join(f"{name} {version}" for name, version in versions().items()),
    }
    packages = find_nearby_packages(os.getcwd())
    if packages:
        facts["packages near this folder"] = f"{', '.join(packages)}; pyros1 itself adds them to ROS_PACKAGE_PATH"
    return format_report(facts, examination.machine, examination.system, examination.types, examination.findings)


def _introduction_text(checks_packages: bool, files: Iterable[str]) -> str:
    if files:
        return f"Launch files: {', '.join(files)}"
    candidates = (Path.cwd(), *Path.cwd().parents)
    folder = next((folder for folder in candidates if (folder / "package.xml").is_file()), None)
    location = f"Package: {folder.name}" if folder else "No package or stack in the current directory"
    return f"{location}\nroswtf will run against all packages" if checks_packages else location


def _launch_problems(files: list[str], args: list[str]) -> list[str]:
    """Return the problems that `launch --check` reports for the files."""
    if not files:
        return []
    from pyros1.ground.errors import LaunchError  # noqa: PLC0415 - only needed for launch files
    from pyros1.launch.reading.cli_arguments import find_launch_files, parse_arguments  # noqa: PLC0415
    from pyros1.launch.reading.loader import load_plan  # noqa: PLC0415
    from pyros1.launch.reading.system_resources import make_resources  # noqa: PLC0415
    from pyros1.launch.running.check import plan_errors  # noqa: PLC0415

    resources = make_resources()
    problems: list[LaunchError] = []
    texts: list[str] = []
    try:
        plan = load_plan(find_launch_files(files, resources), parse_arguments(args), resources, problems=problems)
        texts = [*plan.warnings, *map(str, plan_errors(plan, resources.packages, resources.environ))]
    except Error as error:
        texts = [str(error)]
    return [*map(str, problems), *texts]


def _connect_to_master() -> tuple[MasterClient | None, bool]:
    """Return the master, or None if it does not respond, and whether the connection timed out."""
    try:
        master = MasterClient("/roswtf", master_uri(os.environ, {}), timeout=MASTER_TIMEOUT)
    except Error:
        return None, False  # the static checks have reported that the URI is invalid
    try:
        master.ping()
    except MasterUnreachableError as error:
        master.close()
        return None, isinstance(error.__cause__, DeadlineError)
    return master, False


def _unresponsive_master_finding() -> Finding:
    return Finding(
        "silent-master",
        ERROR,
        f"the master at {master_uri(os.environ, {})} did not answer within {MASTER_TIMEOUT:g} s",
        "if its process is suspended, continue it with kill -CONT; if it hangs, stop it and start pyros1 core; "
        "if it is on another machine, check the network and its firewall",
    )


def _no_master_finding(machine: Machine) -> Finding:
    uri = master_uri(os.environ, {})
    try:
        host, _ = parse_uri(uri)
        is_on_this_machine = is_local(host)
    except Error:
        is_on_this_machine = True
    if is_on_this_machine:
        others = [other for other in machine.masters if other.rstrip("/") != uri.rstrip("/")]
        fix = f"pyros1 core{f', or export ROS_MASTER_URI={others[0]}: a master is running there' if others else ''}"
        return Finding("no-master", WARNING, f"no master responds at {uri}", fix)
    return Finding(
        "no-master",
        ERROR,
        f"no master responds at {uri}",
        f"check that ROS_MASTER_URI is correct, that {host} can be reached (ping {host}), that a master is running "
        "there, and that no firewall blocks it",
    )


def print_findings(title: str, findings: list[Finding]) -> None:
    """Print a summary of findings like the stock tool, but with fixes."""
    print(title)
    uses_colour = should_use_colour(sys.stdout)
    for severity, explanation, colour_codes in (
        (WARNING, "Warnings are things that may be just fine, but are sometimes at fault\n", "\x1b[1m"),
        (ERROR, "", "\x1b[31m\x1b[1m"),
    ):
        selected_findings = [finding for finding in findings if finding.severity == severity]
        if not selected_findings:
            continue
        print(f"\nFound {len(selected_findings)} {severity}(s).\n{explanation}")
        for finding in selected_findings:
            label = f"{colour_codes}{severity.upper()}\x1b[0m" if uses_colour else severity.upper()
            print(f"{label} {one_line(finding.text)}", *(f" * {one_line(item)}" for item in finding.items), sep="\n")
            print(f"   fix: {one_line(finding.fix)}\n")
    if not findings:
        print(f"\nNo errors or warnings (pyros1 {__version__}, Python {sys.version.split()[0]})\n")
    sys.stdout.flush()
