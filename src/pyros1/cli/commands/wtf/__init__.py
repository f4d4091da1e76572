"""``pyros1 wtf``: finds problems like roswtf (L178), with more checks and a fix for each. Alias: ``pyros1 doctor``."""

from __future__ import annotations

from typing import Any

from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import parse_all_args
from pyros1.cli.records import Argument, Command, Flag, Verb
from pyros1.cli.shared.printing import print_json


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Print the problems found. Return 1 if there are errors; always 0 if called as the stock tool.

    The arguments are launch files and ``name:=value`` arguments for these files.
    """
    from pyros1.cli.commands.wtf._examine import examine, make_report  # noqa: PLC0415 - not needed for help
    from pyros1.doctor.finding import ERROR  # noqa: PLC0415

    files = [arg for arg in args if ":=" not in arg]
    result = examine(options.everything, options.offline, options.json or options.report, files, args)
    if options.report:
        print(make_report(result), end="")
        return 0
    if options.json:
        print_json([finding.as_json() for finding in result.findings])
    return 1 if not invocation.as_stock and any(finding.severity == ERROR for finding in result.findings) else 0


COMMAND = Command(
    "wtf",
    "find problems on this machine and in the running system, and print how to solve them",
    Verb(
        "",
        "",
        Flag("--all", dest="everything", help="also check all packages"),
        Flag("--no-plugins", help="accepted for compatibility; there are no plugins"),
        Flag("--offline", help="do not check the running system"),
        Flag("--json", help="print findings as JSON", pyros1_only=True),
        Flag("--report", help="print a Markdown report without secrets, for questions and issues", pyros1_only=True),
        Argument("launch file", "launch_file", repeatable=True, optional=True),
        usage="[launch file]\n\n%prog checks a ROS installation and a running system, and launch files if they are "
        "given.\nEach problem is printed with its solution.",
        examples=[
            ("", "check this machine and the running system"),
            ("--offline robot.launch", "check a launch file without a master"),
            ("--json", "print JSON for programs"),
            ("--report > report.md", "write a report to include in a question or an issue"),
        ],
        parse=parse_all_args,
        run=run,
    ),
    group="machine",
    stock="roswtf",
    aliases=["doctor"],
)
