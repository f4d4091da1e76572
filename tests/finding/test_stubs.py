"""stubs: editors and type checkers know all messages, and tell a wrong one."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

from pyros1.cli.main import entry
from pyros1.cli.shared.definitions import library
from pyros1.finding import stubs
from pyros1.finding.library import Library
from pyros1.ground.errors import UnknownTypeError

ROOT = Path(__file__).resolve().parents[2]

WRONG = """
import pyros1
import numpy as np
from pyros1.msgs.geometry_msgs.msg import Twist, Vector3
from pyros1.msgs.sensor_msgs.msg import Image, JointState
from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.msgs.std_srvs.srv import SetBoolRequest

def got(message: Float64) -> None:
    pass

with pyros1.Node("node") as node:
    publisher = node.advertise("topic1", Float64)
    publisher.publish(Float64(1.0))
    publisher.publish(1.0)
    publisher.publish(np.float32(1.0))
    publisher.publish(data=1.0)
    publisher.publish(String("x"))  # wrong
    node.subscribe("topic1", Float64, got)
    node.subscribe("topic2", String, got)  # wrong
    twist = Twist(linear=Vector3(1.0, 0.0, 0.0))
    twist.linear.x = "fast"  # wrong
    twist.speed = 1.0  # wrong
    Vector3(x="fast")  # wrong
    SetBoolRequest(date=True)  # wrong
    state = JointState(name=("a", "b"), position=np.zeros(3), velocity=[1, 2])
    state.effort = np.zeros(3)
    state.name.append("c")
    state.position = 3.0  # wrong
    image = Image(data=[1, 2], height=np.int32(3))
    image.data = bytearray(4)
    image.data = memoryview(b"x")
    image.data.decode()
    from pyros1.msgs.std_msgs.msg import Flot64  # wrong
"""


def check(program: str, folder: Path) -> dict[int, str]:
    """Run mypy --strict over a program; return line -> error."""
    path = folder / "program.py"
    path.write_text(program)
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(ROOT / ".mypy_cache"), str(path)],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        cwd=folder,
        env={"MYPYPATH": str(ROOT / "src"), "PATH": ""},
    )
    assert done.returncode in (0, 1), done.stdout + done.stderr
    return {int(line): text for line, text in re.findall(r"^program\.py:(\d+): error: (.*)", done.stdout, re.M)}


@pytest.mark.slow
@pytest.mark.once
def test_a_type_checker_sees_messages(tmp_path: Path) -> None:
    wrong = {number for number, line in enumerate(WRONG.splitlines(), 1) if line.endswith("# wrong")}
    assert {*check(WRONG, tmp_path)} == wrong


@pytest.mark.slow
@pytest.mark.once
@pytest.mark.parametrize("number", range(2))
def test_the_programs_of_the_readme_have_types(tmp_path: Path, number: int) -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    section = re.search(r"^## A first program\n(.*?)^##", readme, re.M | re.S)
    assert section is not None
    programs = re.findall(r"^```python\n(.*?)^```", section[1], re.M | re.S)
    assert len(programs) == 2, "number says which"
    assert check(programs[number], tmp_path) == {}


def test_the_stubs_that_are_installed_are_current() -> None:
    shipped = stubs.shipped_library()
    files = dict(stubs.generate_stubs(shipped, shipped.packages()))
    there = {path.relative_to(stubs.STUBS_FOLDER) for path in stubs.STUBS_FOLDER.glob("*/*.pyi")}
    assert there == {*files}, "made by the build backend: install pyros1 again"
    for name, text in files.items():
        assert (stubs.STUBS_FOLDER / name).read_text(encoding="utf-8") == text, f"{name} is old: install pyros1 again"


def test_the_build_makes_them() -> None:
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert 'build-backend = "pyros1.finding.build_backend"' in project and '"msgs/*/*.pyi"' in project


NASTY = {
    "msg/Names.msg": "string str\nfloat64 float\nint32 int\nbool bool\nint32[] Sequence\nPoint Point\nTime b\n"
    "duration Time\nstring class\nint32 None_\nint32 X=3\nstring Y= a 'b' \\\"c\nuint8[] data\nuint8[4] four\n"
    "time[] times\nPoint[2] points\n",
    "msg/Point.msg": "float64 x\n",
    "msg/Time.msg": "time data\n",
    "msg/True.msg": "int32 x\n",
    "msg/Empty.msg": "",
    "srv/base.srv": "Names a\n---\nother_pkg/Point b\nother_pkg/Point[] c\nbase/Point d\n",
    "action/Go.action": "int32 goal\n---\nint32 result\n---\nint32 feedback\n",
}


def test_names_that_hide_others(tmp_path: Path) -> None:
    """Fields may be called as what a stub needs, and packages as modules of pyros1."""
    for package in ("base", "other_pkg"):
        for name, text in NASTY.items():
            path = tmp_path / "src" / package / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        (tmp_path / "src" / package / "package.xml").write_text(f"<package><name>{package}</name></package>")
    own = Library({"ROS_PACKAGE_PATH": str(tmp_path / "src")}, installs=())
    out = tmp_path / "out" / "pyros1" / "msgs"
    written = stubs.write_stubs(stubs.generate_stubs(own, ["base", "other_pkg"]), out)
    assert {str(path.relative_to(out)) for path in written} == {
        f"{folder}/{name}.pyi" for folder in ("base_", "other_pkg") for name in ("__init__", "msg", "srv")
    }
    assert stubs.write_stubs(stubs.generate_stubs(own, ["base", "other_pkg"]), out) == [], "nothing has changed"
    text = (out / "base_" / "msg.pyi").read_text()
    names = next(each for each in ast.parse(text).body if isinstance(each, ast.ClassDef) and each.name == "Names")
    fields = {
        each.target.id: ast.unparse(each.annotation)
        for each in names.body
        if isinstance(each, ast.AnnAssign) and isinstance(each.target, ast.Name)
    }
    for each in names.body:
        if isinstance(each, ast.FunctionDef) and each.returns is not None and ast.unparse(each.returns) != "None":
            fields[each.name] = ast.unparse(each.returns)
    assert fields == {
        "str": "_b.str",
        "float": "_b.float",
        "int": "_b.int",
        "bool": "_b.bool",
        "Sequence": "_Sequence[_b.int]",
        "Point": "_base.Point",
        "b": "_base.Time",
        "Time": "_Duration",
        "class_": "_b.str",
        "None_": "_b.int",
        "X": "_ClassVar[_b.int]",
        "Y": "_ClassVar[_b.str]",
        "data": "_b.bytes",
        "four": "_b.bytes",
        "times": "_b.list[_Time]",
        "points": "_b.list[_base.Point]",
    }
    assert "class True" not in text and "class GoActionGoal(_Base)" in text
    for package in ("base_", "other_pkg"):
        text = (out / package / "srv.pyi").read_text()
        assert "def c(self) -> _b.list[_other_pkg.Point]" in text
        assert "from pyros1.msgs.base_ import msg as _base\n" in text, "not pyros1's own module"


def test_an_unknown_package(tmp_path: Path) -> None:
    with pytest.raises(UnknownTypeError, match="did you mean 'std_msgs'"):
        list(stubs.generate_stubs(stubs.shipped_library(), ["std_msg"]))


@pytest.mark.parametrize("form", ["{}", "/{}", "../{}", "", ".", "std_msgs/"])
def test_a_path_is_not_a_package(tmp_path: Path, form: str) -> None:
    (tmp_path / "msg").mkdir()
    with pytest.raises(UnknownTypeError, match="there is no package"):
        list(stubs.generate_stubs(stubs.shipped_library(), [form.format(tmp_path)]))


def test_msg_stubs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    package = tmp_path / "src" / "my_robot"
    (package / "msg").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>my_robot</name></package>")
    (package / "msg" / "State.msg").write_text("float64 x\n")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "src"))
    monkeypatch.setattr(stubs, "STUBS_FOLDER", tmp_path / "home")
    library.cache_clear()
    try:
        for new in (1, 0):
            assert entry(["pyros1", "msg", "stubs", "my_robot"]) == 0
            assert f"1 package, {new} new or changed" in capsys.readouterr().out
        assert "class State(_Base):\n    x: _b.float" in (tmp_path / "home" / "my_robot" / "msg.pyi").read_text()
        assert entry(["pyros1", "msg", "stubs", "my_robt"]) == 1
        assert capsys.readouterr().out == ""
        monkeypatch.setattr(stubs, "STUBS_FOLDER", tmp_path / "src" / "my_robot" / "package.xml")
        assert entry(["pyros1", "msg", "stubs", "my_robot"]) == 1
        assert "install it where you have write permission" in capsys.readouterr().err
    finally:
        library.cache_clear()


def test_msg_stubs_of_packages_that_are_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    texts = {
        "one": "two/T a\nstd_msgs/Header b\nnowhere/T c\n",
        "two": "three/T[] a\none/T b\n",
        "three": "",
        "four": "",
    }
    for package, text in texts.items():
        folder = tmp_path / "src" / package
        (folder / "msg").mkdir(parents=True)
        (folder / "package.xml").write_text(f"<package><name>{package}</name></package>")
        (folder / "msg" / "T.msg").write_text(text)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "src"))
    monkeypatch.setattr(stubs, "STUBS_FOLDER", tmp_path / "home")
    library.cache_clear()
    try:
        assert entry(["pyros1", "msg", "stubs", "one"]) == 0
    finally:
        library.cache_clear()
    assert "3 packages, 3 new or changed" in capsys.readouterr().out
    assert {path.name for path in (tmp_path / "home").iterdir()} == {"one", "two", "three"}
