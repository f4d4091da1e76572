"""How programs get our modules: PYTHONPATH, a .pth file, and what they are told if it cannot be.

Feature: programs get our modules -- `pyros1 run`, `launch`, `test`, `setup`, `rospy enable`; a real rospy takes
    precedence
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from programs import SOURCE, run

from pyros1.drop_in.environment import disable, enable, is_enabled
from pyros1.drop_in.finder import MODULES_FOLDER, Finder
from pyros1.finding.python_modules import DROP_IN_START, modules_environment
from pyros1.ground.errors import Error

TAKEN_OVER = sorted(path.stem for path in Path(DROP_IN_START).glob("*.py") if "take_over(" in path.read_text()[:200])
WHERE = "import rospy; print(rospy.__file__)"


def test_a_program_finds_our_rospy_and_message_packages() -> None:
    out = run("import rospy; from std_msgs.msg import String; import std_msgs.msg; print(rospy.__file__)", {})
    assert out.startswith(MODULES_FOLDER)


def test_rospy_imports_no_large_modules_of_python() -> None:
    assert (
        run("import sys, rospy; print({'xmlrpc.client', 'http.client', 'asyncio', 'numpy'} & {*sys.modules})", {})
        == "set()\n"
    )


def test_a_real_rospy_wins_unless_ours_is_asked_for(tmp_path: Path) -> None:
    (tmp_path / "rospy").mkdir()
    (tmp_path / "rospy" / "__init__.py").touch()
    real = {"PYTHONPATH": f"{DROP_IN_START}:{tmp_path}"}
    assert run(WHERE, real) == f"{tmp_path}/rospy/__init__.py\n"
    assert run("import genpy", real, code=1).splitlines()[-1] == "ModuleNotFoundError: No module named 'genpy'"
    assert run(WHERE, {**real, "PYROS1_ROSPY": "pyros1"}).startswith(MODULES_FOLDER)
    assert "No module named 'rospy'" in run(WHERE, {"PYROS1_ROSPY": "stock"}, code=1)


def test_ours_in_front_of_everything_imports_any_module() -> None:
    run("import rospy, json, asyncio, decimal; from std_msgs.msg import String", {"PYROS1_ROSPY": "pyros1"})


def test_the_users_sitecustomize_runs_too(tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text("print('mine')")
    assert run("import rospy, sitecustomize", {"PYTHONPATH": f"{DROP_IN_START}:{tmp_path}"}) == "mine\n"
    (tmp_path / "sitecustomize.py").write_text("raise RuntimeError('an error of theirs')")
    run("import rospy", {"PYTHONPATH": f"{DROP_IN_START}:{tmp_path}"})


@pytest.mark.slow
@pytest.mark.parametrize("name", TAKEN_OVER)
def test_another_sitecustomize_before_ours(tmp_path: Path, name: str) -> None:
    """Debuggers and tools that measure bring one, and most do not run the next."""
    (tmp_path / "sitecustomize.py").write_text("print('theirs')")
    hidden = {"PYTHONPATH": f"{tmp_path}:{DROP_IN_START}:{SOURCE}"}
    program = f"import {name}, rospy.names; print({name}.__spec__.name, rospy.__file__)"
    theirs, found = run(program, hidden).splitlines()
    assert theirs == "theirs" and found.startswith(f"{name} {MODULES_FOLDER}")


def test_another_sitecustomize_hides_neither_a_real_rospy_nor_the_word_on_a_missing_one(tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").touch()
    (tmp_path / "real" / "rospy").mkdir(parents=True)
    (tmp_path / "real" / "rospy" / "__init__.py").touch()
    hidden = {"PYTHONPATH": f"{tmp_path}:{DROP_IN_START}:{SOURCE}"}
    assert (
        run(WHERE, {"PYTHONPATH": f"{hidden['PYTHONPATH']}:{tmp_path / 'real'}"})
        == f"{tmp_path}/real/rospy/__init__.py\n"
    )
    assert "No module named 'rospy'" in run(WHERE, {**hidden, "PYROS1_ROSPY": "stock"}, code=1)
    assert DROP_IN_START not in run("import sys, std_msgs.msg; print(sys.path)", hidden)


@pytest.mark.slow
def test_threads_that_import_at_once_do_not_wait_for_each_other() -> None:
    program = """
import importlib, threading
names = ["rospy", "std_msgs.msg", "genpy", "json", "nav_msgs.msg", "pyros1.node", "wave", "pyros1.bag", "nothing_here"]
together = threading.Barrier(len(names))
def get(name):
    together.wait()
    try:
        importlib.import_module(name)
    except ModuleNotFoundError as error:
        print(error)
threads = [threading.Thread(target=get, args=(name,)) for name in names]
[each.start() for each in threads]
[each.join(20) for each in threads]
print([each.name for each in threads if each.is_alive()])
"""
    assert run("import rospy" + program, {}).splitlines() == ["No module named 'nothing_here'", "[]"]
    # Two threads that import a package and a module of it for the first time may get Python's own _DeadlockError; none
    # may hang.
    for first in ("import pyros1", ""):
        assert run(first + program, {}).splitlines()[-1] == "[]"


def test_a_python_without_pyros1_says_what_to_do(tmp_path: Path) -> None:
    program = "import sys; sys.modules['pyros1'] = None; import rospy"
    out = run(program, {"PYROS1_PYTHON": "/robot/bin/python"}, code=1)
    assert f"this program runs with {sys.executable}, which has neither ROS nor pyros1" in out
    assert "source /robot/bin/activate" in out
    assert "Run it with the Python of pyros1's environment" in run(program, {"PYROS1_PYTHON": ""}, code=1)
    assert "pyros1:" not in run("import nothing_of_that_name", {}, code=1)


@pytest.mark.parametrize("text", ["print 'x'", "import Queue", "xrange(3)", "{}.has_key(1)", "raise ValueError, 'x'"])
def test_a_program_for_python_2_gets_a_word(tmp_path: Path, text: str) -> None:
    known = text not in ("raise ValueError, 'x'",)  # "invalid syntax" may be anything
    assert ("for Python 2, which is unsupported since 2020" in run(text, {}, code=1)) == known


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("import yaml; yaml.load('a: 1')", "write yaml.safe_load(...)"),
        ("import collections; collections.Mapping", "write collections.abc.Mapping"),
        ("from collections import Iterable", "write collections.abc.Iterable"),
        ("import time; time.clock()", "write time.perf_counter"),
        ("import collections; collections.Mappings", None),
    ],
)
def test_a_program_for_an_older_python_3_gets_a_word(text: str, word: str | None) -> None:
    out = run(text, {}, code=1)
    said = out.partition("pyros1: this program was written for an older version of Python or of a library. ")[2]
    assert word in said if word else not said


def test_all_programs_of_an_environment(tmp_path: Path) -> None:
    file, errors = enable(str(tmp_path), {})
    assert not errors
    assert is_enabled(str(tmp_path))
    program = f"import site; site.addsitedir({str(tmp_path)!r}); import sys; print('start' in str(sys.path)); {WHERE}"
    first, second = run(program, {"PYTHONPATH": ""}).splitlines()
    assert first == "False"
    assert second.startswith(MODULES_FOLDER)
    file.write_text(file.read_text().replace(DROP_IN_START, "/no/longer/there"))
    assert not is_enabled(str(tmp_path))
    assert "No module named 'rospy'" in run(program, {"PYTHONPATH": ""}, code=1)
    assert disable(str(tmp_path))
    assert not disable(str(tmp_path))
    assert not list(tmp_path.iterdir())


def test_programs_of_an_environment_that_use_no_ros_import_nothing_of_it(tmp_path: Path) -> None:
    enable(str(tmp_path), {})
    program = (
        f"import site, sys; site.addsitedir({str(tmp_path)!r}); site.execsitecustomize(); site.execusercustomize(); "
        "print([name for name in sys.modules if name.startswith('pyros1.')])"
    )
    assert run(program, {"PYTHONPATH": ""}) == "[]\n"


def test_the_file_of_an_environment_is_plain_ascii(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "pyros1.drop_in.environment.DROP_IN_START", "/home/J\xf6rg/\udcff"
    )  # Python reads it as the locale says
    assert enable(str(tmp_path), {})[0].read_bytes().isascii()
    assert is_enabled(str(tmp_path))


def test_a_folder_that_cannot_be_written_is_named() -> None:
    with pytest.raises(Error, match=r"cannot write /dev/null/pyros1_rospy_stubs.*: Not a directory; use a virtual env"):
        enable("/dev/null", {})
    with pytest.raises(Error, match="cannot remove"):
        disable("/dev/null")


def test_the_path_that_users_set_stays_behind_ours() -> None:
    assert modules_environment({"PYTHONPATH": "/a:/b"})["PYTHONPATH"] == f"{DROP_IN_START}:/a:/b"
    assert modules_environment({"PYTHONPATH": f"/a:{DROP_IN_START}"})["PYTHONPATH"] == f"{DROP_IN_START}:/a"
    assert modules_environment({"PYROS1_ROSPY": "stock"}) == {}


def test_python_modules_of_ros_packages_are_found(tmp_path: Path) -> None:
    package = tmp_path / "my_robot"
    for folder in ("msg", "srv", "src/my_robot"):
        (package / folder).mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>my_robot</name></package>")
    (package / "msg" / "State.msg").write_text("float64 charge\nHeader header\n")
    (package / "srv" / "Go.srv").write_text("---\nbool ok\n")
    (package / "src" / "my_robot" / "__init__.py").write_text("")
    (package / "src" / "my_robot" / "wheels.py").write_text("count = 4\n")
    program = """
from my_robot.msg import State
from my_robot.srv import Go, GoRequest, GoResponse
import my_robot.wheels
print(State(charge=2.0).charge, State._type, GoResponse(True).ok, my_robot.wheels.count)
"""
    assert run(program, {"ROS_PACKAGE_PATH": str(tmp_path)}) == "2.0 my_robot/State True 4\n"


def test_names_of_our_modules_and_of_python_are_left_alone() -> None:
    finder = Finder()
    assert finder.find_spec("json") is None
    assert finder.find_spec("pyros1.nothing") is None
    assert finder.find_spec("no_package_of_that_name") is None
    assert finder.find_spec("rospy") is not None
