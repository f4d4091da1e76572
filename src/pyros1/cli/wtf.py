"""``pyros1 wtf``: roswtf (L178), and what else costs users days, each with its cure. ``pyros1 doctor`` is the same."""

from __future__ import annotations

from optparse import OptionParser

from pyros1.cli.common import print_json, program_name, quiet_pipe
from pyros1.cli.usage import Parser

_EXAMPLES = {
    "%prog": "check this machine and the system that runs",
    "%prog --offline robot.launch": "check a launch file, without a master",
    "%prog --json": "for programs",
}


def main(argv: list[str]) -> int:
    """Run ``wtf``.

    Args:
        argv: the words behind: options, launch files and ``name:=value`` for these.

    Returns:
        The exit code: 1 if errors were found, but 0 under the name of the stock tool, as that returns.
    """
    stock = program_name("roswtf") == "roswtf"
    parser = _parser(stock)
    options, words = parser.parse_args(argv)
    from pyros1.cli.wtf_run import examine  # noqa: PLC0415 - help needs none of it
    from pyros1.doctor.finding import ERROR  # noqa: PLC0415

    files = [word for word in words if ":=" not in word]
    try:
        findings = examine(options.everything, options.offline, options.json, files, words)
    except BrokenPipeError:
        return quiet_pipe()
    if options.json:
        print_json([finding.as_json() for finding in findings])
    return 1 if not stock and any(finding.severity == ERROR for finding in findings) else 0


def _parser(stock: bool) -> OptionParser:
    usage = (
        "%prog [launch file]\n\n%prog verifies a ROS installation and a running system, and launch files if they are "
        "given.\nIt names what is wrong, and the cure."
    )
    parser = OptionParser(usage=f"usage: {usage}", prog="roswtf") if stock else Parser("roswtf", usage, _EXAMPLES)
    parser.add_option("--all", action="store_true", dest="everything", default=False, help="check all packages, too")
    parser.add_option("--no-plugins", action="store_true", help="accepted; there are no plugins")
    parser.add_option("--offline", action="store_true", default=False, help="do not look at the running system")
    parser.add_option(
        "--json", action="store_true", default=False, help="SUPPRESSHELP" if stock else "print findings as JSON"
    )
    return parser
