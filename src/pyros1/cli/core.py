"""``pyros1 core``: the master, the parameter server and rosout (https://wiki.ros.org/roscore)."""

from __future__ import annotations

from pyros1.cli.usage import Parser
from pyros1.errors import Error

_EXAMPLES = {
    "%prog": "listen on the port of ROS_MASTER_URI, or 11311",
    "%prog -p 11312": "listen on another port",
    "%prog --sigint-timeout 1": "give what ignores Ctrl-C one second",
}


def main(argv: list[str]) -> int:
    """Run ``pyros1 core`` (L06-L19).

    Args:
        argv: the words after the command's name.

    Returns:
        The exit code: 0 after a normal end, 1 when it could not start, 2 for a wrong command line.
    """
    parser = Parser("roscore", "%prog [options]", _EXAMPLES)
    add = parser.add_option
    add("-p", "--port", metavar="PORT", dest="port", type="int", help="master port. Only valid if master is launched")
    add("-v", action="store_true", dest="verbose", default=False, help="verbose printing")
    add("-w", "--numworkers", metavar="NUM_WORKERS", dest="num_workers", type="int", help="accepted; no workers needed")
    add("-t", "--timeout", metavar="TIMEOUT", dest="timeout", type="float", help="seconds that nodes have to answer")
    add("--master-logger-level", metavar="LEVEL", dest="level", default="", help="least level in master.log")
    add(
        "--sigint-timeout",
        metavar="SECONDS",
        dest="sigint_timeout",
        type="float",
        help="seconds from SIGINT to SIGTERM",
    )
    add("--sigterm-timeout", metavar="SECONDS", dest="sigterm_timeout", type="float", help="and from there to SIGKILL")
    options, words = parser.parse_args([word for word in argv if not word.startswith("__")])
    if words:
        parser.error(f"{parser.get_prog_name()} does not take arguments")

    from pyros1.cli import launch as cli  # noqa: PLC0415 - after the command line proved right
    from pyros1.cli.launch_options import make_parser  # noqa: PLC0415
    from pyros1.launch.plan import Plan  # noqa: PLC0415
    from pyros1.launch.world import make_resources  # noqa: PLC0415

    values = make_parser().get_default_values()
    values.core = True
    values.port = options.port
    values.timeout = options.timeout
    values.master_logger_level = options.level
    if options.sigint_timeout is not None:
        values.sigint_timeout = options.sigint_timeout
    if options.sigterm_timeout is not None:
        values.sigterm_timeout = options.sigterm_timeout
    try:
        return cli.launch(Plan(), values, make_resources(), title="roscore")
    except Error as error:
        cli.print_exception(error)
        return 1
