"""``pyros1 wtf``: roswtf (L178), and what else costs users days, each with its cure. ``pyros1 doctor`` is the same."""

from __future__ import annotations

from typing import Any

from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import parse_all_words
from pyros1.cli.records import Argument, Command, Flag, Verb
from pyros1.cli.shared.printing import print_json


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Print what is wrong; the exit code is 1 if there are errors, but under the stock tool's name 0, as that returns.

    Arguments are launch files, and ``name:=value`` for these.
    """
    from pyros1.cli.commands.wtf._examine import examine  # noqa: PLC0415 - help needs none of it
    from pyros1.doctor.finding import ERROR  # noqa: PLC0415

    files = [word for word in args if ":=" not in word]
    findings = examine(options.everything, options.offline, options.json, files, args)
    if options.json:
        print_json([finding.as_json() for finding in findings])
    return 1 if not invocation.as_stock and any(finding.severity == ERROR for finding in findings) else 0


COMMAND = Command(
    "wtf",
    "find what is wrong with this machine and the running system, and the cure",
    Verb(
        "",
        "",
        Flag("--all", dest="everything", help="check all packages, too"),
        Flag("--no-plugins", help="accepted; there are no plugins"),
        Flag("--offline", help="do not look at the running system"),
        Flag("--json", help="print findings as JSON", own=True),
        Argument("launch file", "launch_file", many=True, optional=True),
        usage="[launch file]\n\n%prog verifies a ROS installation and a running system, and launch files if they are "
        "given.\nIt names what is wrong, and the cure.",
        examples=[
            ("", "check this machine and the system that runs"),
            ("--offline robot.launch", "check a launch file, without a master"),
            ("--json", "for programs"),
        ],
        parse=parse_all_words,
        run=run,
    ),
    group="machine",
    stock="roswtf",
    aliases=["doctor"],
)
