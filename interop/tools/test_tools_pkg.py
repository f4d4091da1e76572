"""Packages that `pyros1 pkg create` makes, in the hands of stock ROS; catkin_create_pkg beside ours.

Feature: one command creates a package that runs without a build -- catkin_make also builds it; in a shell with a
    Python environment: `catkin_make -DPYTHON_EXECUTABLE=/usr/bin/python3`
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from harness import SOURCE, Master

from pyros1.cli.commands.setup._programs import make_programs
from pyros1.cli.registry import stock_names

STOCK_PATH = "/usr/bin:/bin"


def environment(place: Path, **more: str) -> dict[str, str]:
    return {"PATH": STOCK_PATH, "HOME": str(place), "PYTHONPATH": str(SOURCE), "ROS_HOME": str(place / "ros"), **more}


def run(words: list[str], cwd: Path, environ: dict[str, str], timeout: float = 60) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        words,
        cwd=cwd,
        env=environ,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )


def uncomment(text: str, function: str) -> str:
    """Take the # from the lines of a call, as ROS's tutorials ask their readers to do."""
    start = text.index(f"# {function}(\n")
    end = text.index("# )\n", start) + len("# )\n")
    return text[:start] + "".join(line[2:] for line in text[start:end].splitlines(keepends=True)) + text[end:]


def follow_the_tutorial(package: Path) -> None:
    """Do in a new package what https://wiki.ros.org/ROS/Tutorials/CreatingMsgAndSrv says."""
    for file, text in {
        "msg/Num.msg": "int64 num\n",
        "srv/AddTwoInts.srv": "int64 a\nint64 b\n---\nint64 sum\n",
    }.items():
        (package / file).parent.mkdir()
        (package / file).write_text(text)
    manifest = (package / "package.xml").read_text()
    for tag in ("<build_depend>message_generation</build_depend>", "<exec_depend>message_runtime</exec_depend>"):
        assert f"<!-- {tag} -->" in manifest
        manifest = manifest.replace(f"<!-- {tag} -->", tag)
    (package / "package.xml").write_text(manifest)
    text = (package / "CMakeLists.txt").read_text()
    for function in ("add_message_files", "add_service_files", "generate_messages"):
        text = uncomment(text, function)
    text = text.replace("  std_msgs\n)", "  std_msgs\n  message_generation\n)", 1)
    text = text.replace("  # message_runtime", "  message_runtime")
    text = text.replace("  Message1.msg", "  Num.msg").replace("  Service1.srv", "  AddTwoInts.srv")
    (package / "CMakeLists.txt").write_text(text)


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace with packages made by us, one of them edited as a tutorial says, built by stock's catkin_make."""
    place = tmp_path_factory.mktemp("workspace")
    (place / "src").mkdir()
    create = [sys.executable, "-m", "pyros1", "pkg", "create", "my_robot", "std_msgs"]
    assert run(create, place / "src", environment(place)).returncode == 0
    create = [sys.executable, "-m", "pyros1", "pkg", "create", "--no-examples", "tutorial", "std_msgs", "rospy"]
    assert run(create, place / "src", environment(place)).returncode == 0
    follow_the_tutorial(place / "src" / "tutorial")
    examples = [word for name in ("service", "action", "reconfigure", "urdf") for word in ("--example", name)]
    create = [sys.executable, "-m", "pyros1", "pkg", "create", "copied", "--face", "rospy", *examples]
    assert run(create, place / "src", environment(place)).returncode == 0
    built = run(["catkin_make", "-j2"], place, environment(place), 300)
    assert built.returncode == 0, built.stdout[-3000:] + built.stderr[-3000:]
    return place


def in_workspace(place: Path, command: str, **more: str) -> subprocess.CompletedProcess[str]:
    return run(["bash", "-c", f"source devel/setup.bash && {command}"], place, environment(place, **more))


def test_catkin_make_builds_its_message(workspace: Path) -> None:
    code = "from my_robot.msg import Measurement as M; print(M._md5sum)"
    stock = in_workspace(workspace, f"/usr/bin/python3 -c '{code}'")
    ours = run(
        [sys.executable, "-m", "pyros1", "msg", "md5", "my_robot/Measurement"],
        workspace / "src",
        environment(workspace),
    )
    assert stock.returncode == ours.returncode == 0, stock.stderr + ours.stderr
    assert stock.stdout == ours.stdout != ""


def test_what_the_tutorial_adds_is_built(workspace: Path) -> None:
    code = "from tutorial.msg import Num; from tutorial.srv import AddTwoInts; print(Num._type, AddTwoInts._type)"
    done = in_workspace(workspace, f"/usr/bin/python3 -c '{code}'")
    assert done.stdout == "tutorial/Num tutorial/AddTwoInts\n", done.stderr


def test_examples_are_built(workspace: Path) -> None:
    code = (
        "from copied.srv import Divide; from copied.msg import CountAction; from copied.cfg import OscillatorConfig; "
        "print(Divide._type, CountAction._type, OscillatorConfig.Oscillator_square)"
    )
    done = in_workspace(workspace, f"/usr/bin/python3 -c '{code}'")
    assert done.stdout == "copied/Divide copied/CountAction 1\n", done.stderr


def test_stock_tools_find_it(workspace: Path) -> None:
    found = in_workspace(
        workspace, "rospack find my_robot && rospack depends1 my_robot && rosmsg show my_robot/Measurement"
    )
    assert found.stdout == f"{workspace}/src/my_robot\nmessage_runtime\nstd_msgs\ntime stamp\nfloat64 value\n\n"


def test_catkin_installs_its_nodes(workspace: Path) -> None:
    assert in_workspace(workspace, "catkin_make install").returncode == 0
    installed = {str(path.relative_to(workspace / "install")) for path in (workspace / "install").rglob("*")}
    assert {
        "lib/my_robot/minimal_publisher",
        "share/my_robot/launch/minimal.launch",
        "share/my_robot/msg/Measurement.msg",
        "lib/copied/count_server.py",
        "share/copied/urdf/arm.urdf",
    } <= installed


def test_stock_rosrun_runs_its_node(workspace: Path, own_master: Callable[[str], Master]) -> None:
    """The node runs on whatever python3 the PATH has, if that has pyros1."""
    programs = workspace / "programs"
    programs.mkdir()
    (programs / "python3").write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    (programs / "python3").chmod(0o755)
    master = own_master("stock")
    master.start()
    environ = {"ROS_MASTER_URI": master.uri, "ROS_HOSTNAME": "localhost", "PATH": f"{programs}:{STOCK_PATH}"}
    done = in_workspace(
        workspace,
        "{ rosrun my_robot minimal_publisher _rate:=50 & }; publisher=$!; "
        "timeout -k 5 30 rostopic echo -n 2 /measurements/value; code=$?; "
        "kill $publisher; wait $publisher; exit $code",
        **environ,
    )
    assert done.returncode == 0, done.stderr
    values = [float(line) for line in done.stdout.split() if line != "---"]
    assert len(values) == 2 and values[1] == pytest.approx(values[0] + 0.001)


def test_stock_roslaunch_reads_its_launch_file(workspace: Path) -> None:
    done = in_workspace(workspace, "roslaunch --nodes my_robot minimal.launch")
    assert done.stdout.split() == ["/minimal_publisher", "/minimal_subscriber"], done.stderr


@pytest.mark.parametrize("words", [["--no-examples", "std_msgs", "roscpp"], ["--meta", "std_msgs"], []])
def test_every_kind_of_package_is_configured_by_cmake(tmp_path: Path, words: list[str]) -> None:
    name = "other_robot"
    create = run([sys.executable, "-m", "pyros1", "pkg", "create", name, *words], tmp_path, environment(tmp_path))
    assert create.returncode == 0, create.stderr
    done = run(["cmake", "-S", name, "-B", "build"], tmp_path, environment(tmp_path), 120)
    assert done.returncode == 0, done.stderr[-2000:]
    assert "Warning" not in done.stderr


# catkin_create_pkg ----------------------------------------------------------------------------------------------------


@pytest.fixture
def programs(tmp_path: Path) -> Path:
    return make_programs(stock_names(), {"XDG_DATA_HOME": str(tmp_path / "data")})


@pytest.mark.parametrize(
    "words",
    [
        "my_robot",
        "my_robot std_msgs rospy",
        "my_robot roscpp",
        "my_robot std_msgs -V 1.2.3 -D words -l BSD -a me -m you",
        "my_robot std_msgs --rosdistro noetic",
        "all_of_it --meta",
        "Bad-Name",
        "",
        "my_robot --nonsense",
    ],
)
def test_catkin_create_pkg(tmp_path: Path, programs: Path, words: str) -> None:
    """The same files and words, and catkin reads the same out of both package.xml."""
    answers = []
    for tool in (Path("/usr/bin/catkin_create_pkg"), programs / "catkin_create_pkg"):
        place = tmp_path / "place"
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir()
        done = run([str(tool), *words.split()], place, environment(tmp_path))
        again = run([str(tool), *words.split()], place, environment(tmp_path))
        made = sorted(str(path.relative_to(place)) for path in place.rglob("*"))
        answers.append((done.returncode, done.stdout, bool(done.stderr), again.returncode, made, parsed(place)))
    assert answers[1] == answers[0]


def parsed(place: Path) -> list[str]:
    """What catkin_pkg understands."""
    code = (
        "import sys; from catkin_pkg.package import parse_package as p\n"
        "for f in sys.argv[1:]:\n"
        "  k = p(f); d = lambda x: sorted(str(e) for e in x)\n"
        "  print(k.name, k.version, k.description, k.licenses, d(k.buildtool_depends), d(k.build_depends),"
        " d(k.build_export_depends), d(k.exec_depends), k.is_metapackage(), [a.name for a in k.authors],"
        " [m.name for m in k.maintainers if m.name != 'user' and m.name != 'root'])"
    )
    files = [str(path) for path in place.rglob("package.xml")]
    done = run(["/usr/bin/python3", "-c", code, *files], place, {**os.environ, "PATH": STOCK_PATH})
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()
