"""``pyros1 launch``: runs launch files (L147-L172, https://wiki.ros.org/roslaunch/Commandline%20Tools)."""

from __future__ import annotations

import os
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation, called_as
from pyros1.cli.parsing import parse_arg_list
from pyros1.cli.records import Argument, Command, Flag, Option, Verb
from pyros1.cli.shared.launching import launch, print_exception
from pyros1.ground.errors import Error
from pyros1.launch.reading.cli_arguments import CommandLineError, find_launch_files, parse_arguments

_EXCLUSIVE_QUERIES = ("node_list", "find_node", "node_args", "ros_args")
"""The queries that cannot be combined with each other."""
_QUERIES = (*_EXCLUSIVE_QUERIES, "dump_params", "file_list", "graph", "tree")
"""All queries, which print something about the launch files and start nothing."""
_TOOLS = ("--deps", "--logs", "--complete")
"""First arguments that select another tool, which receives the remaining arguments, see `_tools`."""


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Start the nodes of launch files, or answer a query about them.

    Returns:
        The exit code: 1 if a required node failed or nothing could be launched, otherwise 0, even if nodes died.
    """
    if options is None:
        from pyros1.cli.commands.launch._tools import run_tool  # noqa: PLC0415 - rarely needed

        return run_tool(args)
    if options.child_name:
        from pyros1.cli.commands.launch._child import run_child  # noqa: PLC0415 - rarely needed

        return run_child(options, args)
    _check_usage(options, args)
    try:
        return _launch_or_query(options, args, parse_arguments(invocation.argv))
    except CommandLineError as error:
        raise UsageError(str(error)) from None
    except UsageError:
        raise
    except Error as error:
        print_exception(error)
        return 1


def _check_usage(options: Any, args: list[str]) -> None:
    misplaced_options = [option for option in _TOOLS if getattr(options, f"tool_{option[2:]}")]
    if misplaced_options:
        raise UsageError(f"{misplaced_options[0]} must be the first argument")
    if sum(bool(getattr(options, name)) for name in _EXCLUSIVE_QUERIES) > 1:
        raise UsageError("only one of --nodes, --find-node, --args and --ros-args can be given")
    if not args and not options.core:
        raise UsageError("you must specify at least one input file")
    if options.core and args:
        raise UsageError("input files are not allowed in core mode")


def _launch_or_query(options: Any, args: list[str], arguments: dict[str, str]) -> int:
    # These are not needed for help or invalid command lines.
    from pyros1.launch.reading.loader import load_plan  # noqa: PLC0415
    from pyros1.launch.reading.system_resources import make_resources  # noqa: PLC0415

    resources = make_resources()
    if options.check and (options.output_file or _is_folder(args)):
        from pyros1.cli.commands.launch._tools import check_package_files  # noqa: PLC0415

        return check_package_files(args, arguments, options)
    files = find_launch_files(args, resources)
    if options.check:
        from pyros1.cli.commands.launch._queries import print_problems  # noqa: PLC0415

        return print_problems(files, arguments, resources)
    if any(getattr(options, name) for name in _QUERIES):
        from pyros1.cli.commands.launch._queries import print_answer  # noqa: PLC0415

        return print_answer(files, arguments, resources, options)
    plan = load_plan(files, arguments, resources)
    if options.verbose:
        from pyros1.launch.reading.report import list_contents  # noqa: PLC0415

        print(list_contents(plan))
    return launch(plan, options, resources, title=",".join(os.path.basename(file) for file in files) or "roscore")


def _is_folder(args: list[str]) -> bool:
    """Return whether the only argument besides ``NAME=VALUE`` is a folder.

    If there are several arguments, the first may be the name of a package instead.
    """
    paths = [arg for arg in args if "=" not in arg]
    return len(paths) == 1 and os.path.isdir(paths[0])


def _parse(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Return the options (None if another tool is selected) and the positional arguments."""
    args = invocation.argv
    if args and (args[0] in _TOOLS or (args[0] == "--check" and called_as("roslaunch-check"))):
        return None, args
    return parse_arg_list(invocation, verb, [arg for arg in args if ":=" not in arg])


_QUERY_OPTIONS = (
    Flag(
        "--files", dest="file_list", help="print the launch files that would be read, with the files that they include"
    ),
    Option("--args", metavar="NODE_NAME", dest="node_args", help="print a node's environment and command line"),
    Flag("--nodes", dest="node_list", help="print the names of all nodes"),
    Option("--find-node", metavar="NODE_NAME", dest="find_node", help="print the file that defines a node"),
    Flag("--dump-params", help="print all parameters as YAML"),
    Flag("--ros-args", help="print the <arg>s of the file"),
    Flag("--graph", help="print files, nodes and machines as a graph for Graphviz's dot"),
    Flag("--tree", help="print files and nodes as a tree"),
    Flag(
        "--check",
        help="start nothing: load the files, look for all packages and executables, and print every problem. The "
        "exit code is 1 if there are problems. For a folder, check each *.launch file in it. For a folder, or with "
        "-o, also check that package.xml declares the packages that the files need",
    ),
    Option("-o", "--output-file", metavar="FILE", help="with --check: write JUnit results to FILE"),
    Flag(
        "--use-test-depends",
        dest="test_depends",
        help="with --check: accept <test_depend> as the declaration of a dependency",
    ),
    Flag("--ignore-unset-args", help="with --check: accept <arg>s without a value"),
    Flag("--json", help="with --nodes and --files: print a JSON list"),
    Flag(
        "--deps",
        dest="tool_deps",
        help="as the first argument: print the packages that files need. With -v, also print which file needs which "
        "packages; with -w, also print packages that package.xml does not declare",
    ),
    Flag("--logs", dest="tool_logs", help="as the first argument: print the log folder of the running master"),
    Flag(
        "--complete",
        dest="tool_complete",
        help="as the first argument: print the names of a file's <arg>s, for completion in shells",
    ),
)
_LAUNCH_OPTIONS = (
    Option(
        "-c",
        "--child",
        metavar="NAME",
        dest="child_name",
        help="run as the child of a stock launcher on another machine; needs -u and --run_id",
    ),
    Option("-u", "--server_uri", metavar="URI", help="with -c: URI of the parent"),
    Option(
        "--run_id", metavar="RUN_ID", help="id of this run; it is an error if the running master has a different id"
    ),
    Flag("--local", dest="local_only", help="do not start nodes on other machines"),
    Flag("--screen", dest="force_screen", help="send the output of all nodes to the screen"),
    Flag("--log", dest="force_log", help="send the output of all nodes to log files"),
    Flag("--required", dest="force_required", help="end the launch when any node exits"),
    Flag(
        "--preload",
        help="start Python nodes as forks of a process that has already imported pyros1 and rospy, which is faster for "
        "many nodes",
    ),
    Flag("--prefix", help="begin each line on the screen with the node's name, in color on a terminal"),
    Option(
        "--pid",
        metavar="PID_FILE",
        dest="pid_file",
        default="",
        help="write the id of this process to a file, and remove the file at the end",
    ),
    Flag("-v", dest="verbose", help="print everything that is read from the files"),
    Flag("--no-summary", help="do not print the SUMMARY block"),
    Flag("--disable-title", help="do not change the terminal's title"),
    Flag("--skip-log-check", help="accepted for compatibility; the size of the log folder is never checked"),
    Option(
        "--sigint-timeout",
        metavar="SECONDS",
        type="float",
        default=15.0,
        help="seconds from SIGINT to SIGTERM when stopping nodes [15]",
    ),
    Option(
        "--sigterm-timeout",
        metavar="SECONDS",
        type="float",
        default=2.0,
        help="seconds from SIGTERM to SIGKILL when stopping nodes [2]",
    ),
)
_MASTER_OPTIONS = (
    Flag("--wait", dest="wait_for_master", help="wait for a master instead of starting one"),
    Option("-p", "--port", metavar="PORT", type="int", help="port of the master to start"),
    Flag("--core", help="start a master and rosout, and no nodes"),
    Option(
        "-w",
        "--numworkers",
        metavar="NUM_WORKERS",
        dest="num_workers",
        type="int",
        default=3,
        help="accepted for compatibility; no effect",
    ),
    Option(
        "-t",
        "--timeout",
        metavar="TIMEOUT",
        type="float",
        help="if this launch starts a master: seconds that the master waits for a node to respond",
    ),
    Option(
        "--master-logger-level",
        metavar="LEVEL",
        default="",
        help="if this launch starts a master: lowest level written to master.log: debug, info, warn, error or fatal",
    ),
)

VERB = Verb(
    "",
    "",
    *_QUERY_OPTIONS,
    *_LAUNCH_OPTIONS,
    *_MASTER_OPTIONS,
    Argument("package", "package|launch_file", optional=True),
    Argument("<filename>", "package_launch_file|launch_arg"),
    Argument("arg_name:=value", "launch_arg", repeatable=True, optional=True),
    usage="""[options] [package] <filename> [arg_name:=value...]
       %prog [options] <filename> [<filename>...] [arg_name:=value...]

If <filename> is a single dash ('-'), launch XML is read from standard input.""",
    examples=[
        ("robot.launch", "start a file's nodes until Ctrl-C"),
        ("my_robot robot.launch sim:=true", "start a launch file of a package, with a value for the file's <arg> sim"),
        ("--check robot.launch", "start nothing, but print every problem"),
        ("--nodes robot.launch", "print the names of the nodes"),
    ],
    stock_examples=True,
    parse=_parse,
    run=run,
)

COMMAND = Command(
    "launch",
    "start the nodes of a launch file",
    VERB,
    group="run",
    stock="roslaunch",
    other_programs={
        "roslaunch-check": ["--check"],
        "roslaunch-complete": ["--complete"],
        "roslaunch-deps": ["--deps"],
        "roslaunch-logs": ["--logs"],
    },
)
