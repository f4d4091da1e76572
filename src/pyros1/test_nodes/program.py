"""The program of all test nodes: runs the test cases and writes the results for rostest."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from pyros1.ground.errors import Error
from pyros1.launch.testing.junit import Results, describe_case, write_results
from pyros1.node import Node
from pyros1.test_nodes import advertise, analyzers, hz, param, publish
from pyros1.test_nodes.common import run_case

_OUTPUT_OPTION = "--gtest_output=xml:"
_SUITE_NAME = "unittest.suite.TestSuite"
NODES = {
    "analyzer_loader": ("AnalyzerLoader", analyzers.tests),
    "hztest": ("HzTest", hz.tests),
    "paramtest": ("ParamTest", param.tests),
    "publishtest": ("PublishTest", publish.tests),
    "advertisetest": ("AdvertiseTest", advertise.advertise_tests),
    "subscribetest": ("SubscribeTest", advertise.subscribe_tests),
}
"""For each node, by name: its class name in the results of stock ROS, and a function that returns its test cases."""


def main(argv: list[str]) -> int:
    """Run a test node.

    Args:
        argv: the command line, which begins with the node's path. ``--gtest_output=xml:FILE`` names the file for the
            results. With ``--text``, the results are printed, but not written to a file.

    Returns:
        The exit code: 0 if all cases passed, else 1.
    """
    name = Path(argv[0]).name
    classname, make_tests = NODES[name]
    try:
        with Node(name, argv=argv[1:]) as node:
            cases = [run_case(case_name, f"__main__.{classname}", test) for case_name, test in make_tests(node).items()]
        results = Results(cases)
        result_files = [
            argument.removeprefix(_OUTPUT_OPTION) for argument in argv if argument.startswith(_OUTPUT_OPTION)
        ]
        if result_files and "--text" not in argv:
            os.makedirs(os.path.dirname(result_files[-1]) or ".", exist_ok=True)
            write_results(Path(result_files[-1]), _SUITE_NAME, results, "", "")
    except (Error, OSError) as error:
        sys.stderr.write(f"ERROR: {name}: {error}\n")
        return 1
    return _report(results)


def _report(results: Results) -> int:
    """Print the results and return the exit code."""
    sys.stdout.write("".join(describe_case(case) for case in results.cases))
    return 1 if results.errors or results.failures else 0
