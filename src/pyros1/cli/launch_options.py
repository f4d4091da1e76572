"""The options of ``pyros1 launch`` (L147-L172)."""

from __future__ import annotations

from optparse import OptionParser

from pyros1.cli.usage import Parser

USAGE = """%prog [options] [package] <filename> [arg_name:=value...]
       %prog [options] <filename> [<filename>...] [arg_name:=value...]

If <filename> is a single dash ('-'), launch XML is read from standard input."""
EXAMPLES = {
    "%prog robot.launch": "start a file's nodes until Ctrl-C",
    "%prog my_robot robot.launch sim:=true": "a file of a package, and a value for one of its args",
    "%prog --check robot.launch": "start nothing, name every problem",
    "%prog --nodes robot.launch": "list the nodes' names",
}
EXCLUSIVE = ("node_list", "find_node", "node_args", "ros_args")
"""Questions of which only one can be asked."""
QUERIES = (*EXCLUSIVE, "dump_params", "file_list", "graph", "tree")
"""All questions that need nothing to be started."""
TOOLS = {"--deps": "deps", "--logs": "logs", "--complete": "complete"}
"""First words that make the rest the command line of another tool -> function in `pyros1.cli.launch_tools`."""


def make_parser() -> OptionParser:
    """Return the parser of the command line."""
    parser = Parser("roslaunch", USAGE, EXAMPLES)
    _add_queries(parser)
    _add_ways(parser)
    _add_master(parser)
    return parser


def _flag(parser: OptionParser, option: str, dest: str, about: str) -> None:
    parser.add_option(option, dest=dest, action="store_true", default=False, help=about)


def _add_queries(parser: OptionParser) -> None:
    add = parser.add_option
    _flag(parser, "--files", "file_list", "print the launch files that would be read, the included ones too")
    add("--args", metavar="NODE_NAME", dest="node_args", help="print a node's environment and command line")
    _flag(parser, "--nodes", "node_list", "print the names of all nodes")
    add("--find-node", metavar="NODE_NAME", dest="find_node", help="print the file that a node stands in")
    _flag(parser, "--dump-params", "dump_params", "print all parameters as YAML")
    _flag(parser, "--ros-args", "ros_args", "print what <arg>s the file has")
    _flag(parser, "--graph", "graph", "print files, nodes and machines as a graph for Graphviz's dot")
    _flag(parser, "--tree", "tree", "print files and nodes as a tree")
    _flag(
        parser,
        "--check",
        "check",
        "start nothing: load everything, look for all packages and executables, print every problem found; exit code 1 "
        "if there is one. Of a folder, or with -o, each *.launch file is checked, and what package.xml declares, too",
    )
    add("-o", "--output-file", metavar="FILE", dest="output_file", help="with --check: write JUnit results to FILE")
    _flag(parser, "--use-test-depends", "test_depends", "with --check: a package's <test_depend> will do")
    _flag(parser, "--ignore-unset-args", "ignore_unset_args", "with --check: <arg>s need no value")
    _flag(parser, "--json", "json", "with --nodes and --files: print a JSON list")
    for option, about in {
        "--deps": "as the first word: print the packages that files need. -v: which file needs what; -w: what "
        "package.xml lacks",
        "--logs": "as the first word: print the folder of the running master's log files",
        "--complete": "as the first word: print the names of a file's <arg>s, for shells",
    }.items():
        _flag(parser, option, f"tool_{TOOLS[option]}", about)


def _add_ways(parser: OptionParser) -> None:
    add = parser.add_option
    add(
        "-c",
        "--child",
        metavar="NAME",
        dest="child_name",
        help="serve a stock parent on another machine; needs -u and --run_id",
    )
    add("-u", "--server_uri", metavar="URI", dest="server_uri", help="with -c: where the parent answers")
    add("--run_id", metavar="RUN_ID", dest="run_id", help="the run id; an error if the master's is another one")
    _flag(parser, "--local", "local_only", "leave out nodes of other machines")
    _flag(parser, "--screen", "force_screen", "all nodes' output to the screen")
    _flag(parser, "--log", "force_log", "all nodes' output to log files")
    _flag(parser, "--required", "force_required", "end everything when any node has ended")
    _flag(parser, "--prefix", "prefix", "each line on the screen begins with the node's name, in colour on a terminal")
    add("--pid", metavar="PID_FILE", dest="pid_file", default="", help="keep this process's id in a file while it runs")
    _flag(parser, "-v", "verbose", "print what is read from the files")
    _flag(parser, "--no-summary", "no_summary", "do not print the SUMMARY block")
    _flag(parser, "--disable-title", "disable_title", "leave the terminal's title alone")
    _flag(parser, "--skip-log-check", "skip_log_check", "accepted; the size of the log folder is never looked at")
    for name, default, stage in (("sigint", 15.0, "SIGINT to SIGTERM"), ("sigterm", 2.0, "SIGTERM to SIGKILL")):
        option, dest = f"--{name}-timeout", f"{name}_timeout"
        about = f"seconds from {stage} when nodes are to end [{default:g}]"
        add(option, metavar="SECONDS", dest=dest, type="float", default=default, help=about)


def _add_master(parser: OptionParser) -> None:
    add = parser.add_option
    _flag(parser, "--wait", "wait_for_master", "wait for a master instead of starting one")
    add("-p", "--port", metavar="PORT", dest="port", type="int", help="port of the master that is started here")
    _flag(parser, "--core", "core", "start a master and rosout, and no nodes")
    add(
        "-w",
        "--numworkers",
        metavar="NUM_WORKERS",
        dest="num_workers",
        type="int",
        default=3,
        help="accepted; a master started here needs no workers",
    )
    add(
        "-t",
        "--timeout",
        metavar="TIMEOUT",
        dest="timeout",
        type="float",
        help="seconds that nodes have to answer a master started here",
    )
    add(
        "--master-logger-level",
        metavar="LEVEL",
        dest="master_logger_level",
        default="",
        help="least level in master.log of a master started here: debug, info, warn, error or fatal",
    )
