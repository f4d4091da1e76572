"""Write ``interop/robots.md``: which nodes of public robots' launch files run without ROS.

::

    python interop/robots.py                      # write the page
    python interop/robots.py --check              # exit code 1 if it is not current
    python interop/robots.py --scan FOLDER ...    # write robots.txt from git repositories of robots (OWNER+NAME/...)

``robots.txt`` has one line for each program: package, type, class of the nodelet (or ``-``), node tags, repositories.
It holds only these names and numbers. Nodes of a repository's own packages are not in it: they run if they are in
Python. ``robot_tests.txt`` has the tests of each program that runs.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "src"))

from pyros1.cli.package_scripts import SCRIPTS  # noqa: E402 - of this checkout
from pyros1.finding.nodelet_programs import find_program, package_of  # noqa: E402

TABLE = ROOT / "interop" / "robots.txt"
TESTS = ROOT / "interop" / "robot_tests.txt"
LAUNCH_TEST = "packages/test_programs_of_robots.py"
"""The test, below ``tests``, that starts most of the programs as nodes of a launch file."""
PAGE = ROOT / "interop" / "robots.md"
_DISTRIBUTIONS = ("noetic", "melodic", "kinetic", "indigo")
_BEFORE = """
dynamic_reconfigure image_transport image_view joint_state_publisher joint_state_publisher_gui minimal_nodes
robot_state_publisher rosbag rostest rqt_bag rqt_console rqt_graph rqt_gui rqt_image_view rqt_launch
rqt_logger_level rqt_plot rqt_publisher rqt_reconfigure rqt_service_caller rqt_tf_tree rqt_top rqt_topic rviz tf
tf2_ros tf2_tools tf2_web_republisher topic_tools turtle_tf2 turtlesim xacro
"""
"""The packages whose programs ran before the common robot nodes were added."""
_ADDED_LATER = {("robot_state_publisher", "state_publisher")}
_OUT_OF_SCOPE = "gazebo_ros controller_manager moveit_ros_move_group moveit_ros_warehouse moveit_ros_benchmarks"
_BEGINNING = """# Nodes of public robots

Written by `interop/robots.py` from `interop/robots.txt`, which lists the `<node>` tags in the launch files of {robots}
public robot repositories, except nodes from their own packages. A program "runs" if pyros1 includes it; a nodelet, if
pyros1 includes an equivalent node. Column "test" lists each program's tests, below `tests`;
`{launch_test}` starts most of the programs together, as nodes in a launch file.

**{now} of {all} nodes ({now_share:.0f} %) run; before the common robot nodes were added, {before}
({before_share:.0f} %) did.** {simulated} of all nodes belong to Gazebo, controller_manager and MoveIt, which pyros1
does not aim to replace. In addition, the repositories have {own} nodes from their own packages.

`pyros1 launch --check` was run on all 786 launch files of these repositories, without an installed ROS, and with a
value for each argument that has no default. 254 are clean. The others refer to missing parts: simulators, controllers
and MoveIt (178 files), navigation (100), drivers, descriptions and other packages (141), programs and nodelets that
must be compiled from the repository itself (80), and things that only the robot or its maker has: settings,
calibration files, removed parts of the repository (33). No complaint concerns a package that pyros1 includes, its
files or its arguments.
"""


class Row(NamedTuple):
    """A program of the table.

    Attributes:
        package, type: as in the node tags.
        nodelet: the class that the program ``nodelet`` loads, "manager", or "-".
        tags: the number of node tags.
        robots: the number of repositories that have some.
    """

    package: str
    type: str
    nodelet: str
    tags: int
    robots: int

    @property
    def runs(self) -> bool:
        """Whether the program runs without ROS."""
        return bool(self.program[1])

    @property
    def program(self) -> tuple[str, str]:
        """The package and program that run for it; the program is empty if there is none."""
        if self.package == "nodelet" and self.nodelet not in ("-", "manager"):
            package = package_of(self.nodelet)
            return package, find_program(self.nodelet, SCRIPTS.get(package, ()))
        names = SCRIPTS.get(self.package, {})
        return self.package, next((name for name in (self.type, f"{self.type}.py") if name in names), "")

    @property
    def ran_before(self) -> bool:
        """Whether it ran before the common robot nodes were added."""
        return self.runs and self.package in _BEFORE.split() and (self.package, self.type) not in _ADDED_LATER


def read_table() -> tuple[list[Row], int, int]:
    """Return the rows of the table, the number of repositories, and of nodes of their own packages."""
    rows, robots, own = [], 0, 0
    for line in TABLE.read_text(encoding="utf-8").splitlines():
        words = line.split("\t")
        if line.startswith("# ") and len(words) == 3:
            robots, own = robots + 1, own + int(words[2].split()[0])
        elif line and not line.startswith("#"):
            package, program, nodelet, num_tags, num_robots = words
            rows.append(Row(package, program, nodelet, int(num_tags), int(num_robots)))
    return rows, robots, own


def read_tests() -> dict[tuple[str, str], list[str]]:
    """Return the tests, below ``tests``, of each package and program."""
    lines = [line.split() for line in TESTS.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    return {(package, program): files for package, program, *files in lines}


def page() -> str:
    """Return the page."""
    rows, robots, own = read_table()
    total = sum(row.tags for row in rows)
    now = sum(row.tags for row in rows if row.runs)
    before = sum(row.tags for row in rows if row.ran_before)
    simulated = sum(
        row.tags for row in rows if row.package in _OUT_OF_SCOPE.split() or row.package.startswith("moveit_")
    )
    lines = [
        _BEGINNING.format(
            launch_test=LAUNCH_TEST,
            robots=robots,
            now=now,
            all=total,
            now_share=100 * now / total,
            before=before,
            before_share=100 * before / total,
            simulated=simulated,
            own=own,
        )
    ]
    tests = read_tests()
    for title, chosen in (
        ("Nodes that run", [row for row in rows if row.runs]),
        ("Nodes that do not run", [row for row in rows if not row.runs]),
    ):
        more = " ran before | test |" if chosen[0].runs else ""
        lines += [f"## {title}\n", f"| package | program | node tags | repositories |{more}"]
        lines.append("|---|---|---|---|" + "---|---|" * bool(more))
        for row in sorted(chosen, key=lambda row: (-row.tags, row)):
            program = row.type if row.nodelet == "-" else f"{row.type} {row.nodelet}"
            line = f"| {row.package} | {program} | {row.tags} | {row.robots} |"
            if row.runs:
                line += f" {'yes' if row.ran_before else 'no'} | {', '.join(tests[row.program])} |"
            lines.append(line)
        lines.append("")
    return "\n".join(lines)


def scan(folders: list[str]) -> str:
    """Return the table for git repositories, each in the newest branch for a ROS 1 distribution.

    Raises:
        ValueError: a folder is not a git repository.
    """
    tags: dict[tuple[str, str, str], list[str]] = defaultdict(list)
    heads = []
    for folder in sorted(folders):
        robot = next((part for part in reversed(Path(folder).parts) if "+" in part), folder).replace("+", "/")
        branch = _branch(folder)
        files = _git(folder, "ls-tree", "-r", "--name-only", "-z", branch).split("\0")
        own_packages = {name for file in files for name in _package_names(folder, branch, file)}
        num_own = 0
        for file in files:
            for key in _nodes_in(folder, branch, file):
                if key[0] in own_packages or (key[0] == "nodelet" and package_of(key[2]) in own_packages):
                    num_own += 1
                else:
                    tags[key].append(robot)
        heads.append(f"# {robot}\t{branch.rpartition('/')[2]}\t{num_own} nodes of its own packages")
    rows = ["\t".join((*key, str(len(robots)), str(len(set(robots))))) for key, robots in sorted(tags.items())]
    return "\n".join((*heads, *rows, ""))


def _branch(folder: str) -> str:
    if not _git(folder, "rev-parse", "--git-dir"):
        raise ValueError(f"{folder} is not a git repository")
    refs = _git(folder, "for-each-ref", "--format=%(refname)", "refs/heads", "refs/remotes").split()
    for distribution in _DISTRIBUTIONS:
        for suffix in ("-devel", ""):
            for ref in refs:
                if ref.rpartition("/")[2] == distribution + suffix:
                    return ref
    return "HEAD"


def _package_names(folder: str, branch: str, file: str) -> list[str]:
    parts = Path(file).parts
    if parts and parts[-1] == "manifest.xml" and len(parts) > 1:
        return [parts[-2]]
    if not parts or parts[-1] != "package.xml":
        return []
    return re.findall(r"<name>\s*(\S+?)\s*</name>", _git(folder, "show", f"{branch}:{file}"))[:1]


def _nodes_in(folder: str, branch: str, file: str) -> list[tuple[str, str, str]]:
    is_launch = file.endswith((".launch", ".launch.xml")) or ("/launch/" in file and file.endswith(".xml"))
    if not is_launch:
        return []
    try:
        root = ElementTree.fromstring(_git(folder, "show", f"{branch}:{file}"))
    except ElementTree.ParseError:
        return []
    if root.tag != "launch":
        return []
    args = {arg.get("name", ""): arg.get("value", arg.get("default", "")) for arg in root.iter("arg")}
    return [_key(tag, args) for tag in root.iter("node") if tag.get("pkg") and tag.get("type")]


def _key(tag: ElementTree.Element, args: dict[str, str]) -> tuple[str, str, str]:
    """Return a node's package, program and nodelet; ``by-argument`` where the file's own arguments do not say which."""

    def words_of(attribute: str) -> list[str]:
        text = re.sub(r"\$\(arg (\w+)\)", lambda found: args.get(found[1]) or found[0], tag.get(attribute, ""))
        return [word if "$" not in word else "by-argument" for word in re.sub(r"\$\([^)]*\)", "$", text).split()]

    package, program = " ".join(words_of("pkg")), " ".join(words_of("type"))
    words = words_of("args")
    if package != "nodelet" or not words:
        return package, program, "-"
    is_named = words[0] in ("load", "standalone") and len(words) > 1
    return package, program, words[1] if is_named else words[0]


def _git(folder: str, *words: str) -> str:
    done = subprocess.run(["git", "-C", folder, *words], capture_output=True, check=False)
    return done.stdout.decode(errors="replace")


def main() -> int:
    """Write or check the page, or write the table; return the exit code."""
    parser = argparse.ArgumentParser(description="write interop/robots.md")
    parser.add_argument("--check", action="store_true", help="only check that the page is current")
    parser.add_argument("--scan", nargs="+", metavar="FOLDER", help="write robots.txt from git repositories")
    options = parser.parse_args()
    if options.scan:
        try:
            TABLE.write_text(scan(options.scan), encoding="utf-8")
        except ValueError as error:
            parser.error(str(error))
        return 0
    if options.check:
        return int(PAGE.read_text(encoding="utf-8") != page())
    PAGE.write_text(page(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
