"""The same launch files through stock roslaunch and pyros1: the answers must be the same, or both refuse.

``launch_corpus/README.md`` says which file shows what, and where pyros1 differs on purpose.

Feature: launch files mean the same as for roslaunch -- parameters, nodes, arguments compared
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
from harness import our_tools, stock_roslaunch
from launch_answers import CORPUS, Answer, ours, stock

TABLE = (CORPUS / "README.md").read_text(encoding="utf-8")
GOOD = sorted(path.stem for path in CORPUS.glob("*.launch"))
BAD = sorted(path.stem for path in (CORPUS / "bad").glob("*.launch"))
ARGUMENTS = {
    "args": ["needed:=1", "opt:=six", "not_declared:=7"],
    "args_undeclared": ["given:=4"],
    "args_cleared": ["a:=", "b:=x:=y", " c:= 3", "_d:=9", "__e:=8", "f/g:=7", "1x:=5", "a-b:=3"],
}
QUERIES = ["--dump-params", "--nodes", "--files", "--ros-args"]
PACKAGE = """<package format="2"><name>{}</name><version>1.0.0</version><description>d</description>
<maintainer email="a@example.org">a</maintainer><license>BSD</license></package>"""
SUMMARY = """
import sys
from roslaunch.config import ROSLaunchConfig
from roslaunch.xmlloader import XmlLoader
config, loader = ROSLaunchConfig(), XmlLoader()
loader.load(sys.argv[1], config, argv=[], verbose=False)
for node in config.nodes:
    node.machine = config.machines[""]
print(config.summary(local=True), end="")
"""
OUR_SUMMARY = """
import sys
from pyros1.launch.reading.system_resources import make_resources
from pyros1.launch.reading import report
from pyros1.launch.reading.loader import load_plan
print(report.summary(load_plan(sys.argv[1:], {}, make_resources())), end="")
"""


def plain(text: str) -> str:
    """Return an answer without what is random in it."""
    return re.sub(r"(?<=[a-z])_\w+_\d+_\d{10,}", "_RANDOM", text)


def same(*words: str, **variables: str) -> Answer:
    """Ask both the same; their answers must be the same."""
    theirs, mine = stock(*words, **variables), ours(*words, **variables)
    if words[0] == "--files":  # stock's order is that of a set
        assert sorted(mine.out.splitlines()) == sorted(theirs.out.splitlines()), mine.err
    else:
        assert plain(mine.out) == plain(theirs.out), mine.err + theirs.err
    assert mine.code == theirs.code
    return theirs


QUESTIONS = [(name, query) for name in GOOD for query in QUERIES]
QUESTIONS.remove(("binary", "--dump-params"))  # stock fails with a traceback: see test_differences


@pytest.mark.parametrize(("name", "query"), QUESTIONS)
def test_query_prints_what_stock_prints(name: str, query: str) -> None:
    answer = same(query, f"{name}.launch", *ARGUMENTS.get(name, []))
    assert answer.code == 0 and "Unable to load" not in answer.err, "the corpus says that stock takes this"


@pytest.mark.parametrize("name", GOOD)
def test_questions_about_each_node(name: str) -> None:
    arguments = ARGUMENTS.get(name, [])
    for node in stock("--nodes", f"{name}.launch", *arguments).out.split("\n"):
        if node and "RANDOM" not in plain(node):
            same(f"--args={node}", f"{name}.launch", *arguments)
            same(f"--find-node={node.lstrip('/')}", f"{name}.launch", *arguments)


@pytest.mark.parametrize("name", BAD)
def test_what_stock_refuses_is_refused_with_its_place(name: str) -> None:
    theirs = stock("--nodes", f"bad/{name}.launch")
    assert theirs.code == 1 and not theirs.out and theirs.err, "the corpus says that stock refuses this"
    mine = ours("--nodes", f"bad/{name}.launch")
    assert (mine.code, mine.out) == (1, "")
    assert mine.err.startswith("RLException: "), mine.err
    assert name == "empty" or re.search(r"\.launch:\d+: ", mine.err.splitlines()[0]), mine.err
    assert "Traceback" not in mine.err


@pytest.mark.parametrize(
    "words",
    [
        ["--nodes", "namespaces.launch", "tests_and_machines.launch"],
        ["--dump-params", "auto_types.launch", "overrides.launch"],
        ["--ros-args", "args.launch", "args_more.launch"],
        ["--files", "includes.launch", "include_scope.launch", "includes.launch"],
        ["--nodes", "summary.launch", "summary.launch"],
        ["--nodes", "--files", "scopes.launch"],
        ["--files", "--dump-params", "scopes.launch"],
        ["--nodes", "--ros-args", "scopes.launch"],
        ["--nodes", "scopes.launch", "no_such.launch"],
        ["--nodes", "no_such.launch"],
        ["--nodes", "no_such_package", "no_such.launch"],
        ["--nodes"],
        ["--nodes", "-", "-"],
        ["--no-such-option", "scopes.launch"],
        ["--core", "scopes.launch"],
        ["-w", "many", "scopes.launch"],
        ["--sigint-timeout", "long", "scopes.launch"],
        ["--args", "/no/such", "scopes.launch"],
        ["--find-node", "/no/such", "scopes.launch"],
        ["--find-node", "same", "tests.launch"],
        ["--args", "same", "tests.launch"],
        ["--args", "g", "node_attributes.launch"],
        ["--args", "h", "node_attributes.launch"],
        ["--dump-params", "bad/not_xml.launch"],
        ["--ros-args", "bad/arg_needed.launch"],
        ["--ros-args", "bad/arg_default_needs.launch"],
        ["--ros-args", "bad/arg_doc_subst.launch"],
        ["--nodes", "scopes.launch", "__ns:=/pushed"],
        ["--dump-params", "scopes.launch", "__ns:=down/"],
        ["--help"],
    ],
    ids=" ".join,
)  # fmt: skip
def test_command_lines(words: list[str]) -> None:
    if words == ["--help"]:  # ours has more options
        theirs, mine = stock(*words), ours(*words)
        assert (
            set(re.findall(r"(?<!\w)--?[a-z][\w-]*", theirs.out)) - set(re.findall(r"--?[a-z][\w-]*", mine.out))
            == set()
        )
        return
    same(*words)


def test_namespace_of_the_environment() -> None:
    for query in ("--nodes", "--dump-params", "--args=n5", "--find-node=a/d/n3"):
        same(query, "scopes.launch", ROS_NAMESPACE="/pushed/down")


@pytest.mark.parametrize("name", [name for name in GOOD if name not in ARGUMENTS])
def test_summary_x82(tmp_path: Path, name: str) -> None:
    answers = []
    for tools, text in ((stock_roslaunch(), SUMMARY), (our_tools(), OUR_SUMMARY)):
        program = tmp_path / f"{len(answers)}.py"
        program.write_text(text)
        env = {**os.environ, "ROS_HOSTNAME": "localhost"}
        answers.append(Answer(*tools.ask([str(program), f"{name}.launch"], env, cwd=CORPUS)))
    theirs, mine = answers
    assert plain(mine.out) == plain(theirs.out), mine.err


def make_package(folder: Path, name: str, **files: str) -> None:
    """Make a package; a file whose text begins with #! is executable."""
    for path, text in {"package.xml": PACKAGE.format(name), **files}.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)
        (folder / path).chmod(0o755 if text.startswith("#!") else 0o644)


def test_packages_of_workspaces_x01_x70(tmp_path: Path) -> None:
    source, devel, install = tmp_path / "src", tmp_path / "devel", tmp_path / "install"
    launch = '<launch><param name="a" value="$(find mine)/run"/><param name="b" value="$(find mine)/launch/x"/>'
    launch += (
        '<param name="c" value="$(find theirs)/run $(find theirs)/data"/><param name="d" value="$(find mine)/made"/>'
    )
    launch += '<node pkg="mine" type="run" name="n"/><node pkg="theirs" type="run" name="m"/></launch>'
    make_package(
        source / "deep" / "mine", "mine", **{"launch/a.launch": launch, "launch/x": "", "scripts/run": "#!/bin/sh"}
    )
    make_package(source / "deep" / "mine", "mine", **{"twice/b.launch": launch, "launch/b.launch": launch})
    make_package(install / "share" / "theirs", "theirs", data="")
    for space, name in ((devel, "mine"), (install, "theirs")):
        (space / "lib" / name).mkdir(parents=True)
        (space / "lib" / name / "run").write_text("#!/bin/sh")
        (space / "lib" / name / "run").chmod(0o755)
    (devel / "share" / "mine").mkdir(parents=True)
    (devel / "share" / "mine" / "made").write_text("")
    (devel / ".catkin").write_text(str(source))
    (install / ".catkin").write_text("")
    env = {
        "ROS_PACKAGE_PATH": f"{source}:{install}/share",
        "CMAKE_PREFIX_PATH": f"{devel}:{install}",
    }
    for query in ("--dump-params", "--nodes", "--files", "--args=n", "--args=m", "--find-node=m"):
        same(query, "mine", "a.launch", **env)
    same("--nodes", "mine", "b.launch", **env)
    same("--nodes", "mine", "c.launch", **env)
    same("--nodes", "mine", "a.launch", str(CORPUS / "evals.launch"), **env)


@pytest.mark.parametrize(
    ("text", "theirs", "mine"),
    [
        ('<param name="a" binfile="/dev/null"/>', None, '/a: !!binary ""\n\n'),
        ('<param name="a" value="deg(180)" type="yaml"/>', "/a: deg(180)\n\n", "/a: 3.141592653589793\n\n"),
        ('<param name="a" value="$(eval len([x for x in range(20000)]))"/>', "/a: 20000\n\n", None),
        ('<param name="a" value="$(eval open(\'/dev/null\').name)"/>', "/a: /dev/null\n\n", None),
        ('<param name="a" value="$(eval factorial(3))"/>', "/a: 6\n\n", None),
        ('<node pkg="p" type="t" name="n" args="\'"/>', "{}\n\n", None),
        ('<node pkg="p" type="t" name=""/>', "{}\n\n", None),
        ('<param name="" value="1"/>', "/: 1\n\n", None),
        ('<rosparam command="dump" param="x"/>', "{}\n\n", None),
        ('<env name="A=B" value="c"/>', "{}\n\n", None),
        ('<arg name="" default="1"/>', "{}\n\n", None),
        ('<test pkg="p" type="t" name="n" test-name=""/>', "{}\n\n", None),
        ('<rosparam command="dump" param="x" file=""/>', "{}\n\n", None),
    ],
)  # fmt: skip
def test_differences(tmp_path: Path, text: str, theirs: str | None, mine: str | None) -> None:
    """What is listed as an intended difference: the answers to --dump-params, None for an error."""
    (tmp_path / "x.launch").write_text(f"<launch>{text}</launch>")
    for expected, answer in (
        (theirs, stock("--dump-params", "x.launch", cwd=tmp_path)),
        (mine, ours("--dump-params", "x.launch", cwd=tmp_path)),
    ):
        refused = answer.code != 0 or "Unable to load" in answer.err
        assert (None if refused else answer.out) == expected, answer.err


@pytest.mark.parametrize("number", [f"X{n:02}" for n in range(1, 95)] + [f"L{n}" for n in range(147, 176)])
def test_every_item_has_its_row(number: str) -> None:
    row = re.search(rf"^\| {number} \|[^|]+\| (.+) \|$", TABLE, re.MULTILINE)
    assert row, f"launch_corpus/README.md has no row for {number}"
    root = Path(__file__).parents[2]
    for place in re.findall(r"`([^`]+)`", row[1]):
        file, _, name = place.partition("::")
        path = next((base / file for base in (root, CORPUS) if (base / file).exists()), None)
        assert path is not None, f"{number}: there is no {file}"
        assert not name or f"def {name}" in path.read_text(encoding="utf-8"), f"{number}: no {name} in {file}"
