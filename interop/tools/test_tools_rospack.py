"""rospack against ours, over all packages of this machine and some that are odd: no master is needed.

Feature: packages are found and listed as by rospack
"""

from __future__ import annotations

import contextlib
import io
import os
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from harness import SOURCE

OWN = {path.name for path in (SOURCE / "pyros1" / "packages").iterdir() if not Path("/usr/share", path.name).exists()}
"""Packages that come with pyros1 and are in no list of stock's."""
GONE = ("    depends-msgsrv ", "    langs", "    vcs ", "    vcs0 ")
"""Verbs of rosbuild's time in stock's list, which ours does not have."""
UNSORTED = ("depends-on", "depends-on1", "plugins")  # stock lists these in the order of its hash table


def stock(words: list[str], environ: dict[str, str], cwd: Path | None = None) -> tuple[int, str, str]:
    environ = {**environ, "PATH": "/usr/bin:/bin"}  # rospack runs the python3 that it finds there
    done = subprocess.run(
        [f"/usr/bin/{words[0]}", *words[1:]],
        env=environ,
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr.replace("could not find rosdep cache, continuing without it\n", "")


def ours(words: list[str]) -> tuple[int, str, str]:
    """Run our command in this process, as under the stock tool's name."""
    from pyros1.cli.main import entry

    out, err = io.StringIO(), io.StringIO()
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        patch.setattr("sys.argv", list(words))
        code = entry(list(words))
    return code, out.getvalue(), err.getvalue()


@pytest.fixture
def environ(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    for name in ("ROS_PACKAGE_PATH", "CMAKE_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("ROS_HOME", str(tmp_path / "ros"))
    monkeypatch.chdir(tmp_path)
    return dict(os.environ)


def lines(text: str, verb: str) -> list[str]:
    found = [line for line in text.split("\n") if line.split(" ")[0] not in OWN and not line.startswith(GONE)]
    return sorted(found) if verb in UNSORTED or verb.endswith("why") else found


def installed(environ: dict[str, str]) -> list[str]:
    return stock(["rospack", "list-names"], environ)[1].split()


def compare(commands: list[list[str]], environ: dict[str, str], cwd: Path | None = None) -> None:
    with ThreadPoolExecutor(2) as pool:
        answers = list(pool.map(lambda words: stock(words, environ, cwd), commands))
    for words, (code, out, err) in zip(commands, answers, strict=True):
        our_code, our_out, our_err = ours(words)
        verb = words[1] if len(words) > 1 else ""
        assert our_code == code, words
        assert lines(our_out, verb) == lines(out, verb), words
        if "failed to parse" not in our_err:  # then stock's own message comes or does not come, from run to run
            assert bool(our_err) == bool(err), (words, our_err, err)


VERBS = ("find", "depends", "depends1", "depends-indent", "depends-manifests", "depends-on1", "rosdep0", "rosdep")


@pytest.mark.parametrize("verb", VERBS)
def test_installed_packages(environ: dict[str, str], verb: str, request: pytest.FixtureRequest) -> None:
    """Every third installed package is asked about with one verb; with ``--long`` every one."""
    step = len(VERBS) if request.config.getoption("--long") else 3 * len(VERBS)
    compare([["rospack", verb, name] for name in installed(environ)[VERBS.index(verb) :: step]], environ)


COMMANDS = [
    "rospack list",
    "rospack list-names",
    "rospack list-duplicates",
    "rospack help",
    "rospack -h",
    "rospack",
    "rospack bogus",
    "rospack find",
    "rospack find nope",
    "rospack find -q nope",
    "rospack -q find nope",
    "rospack find roscpp rospy",
    "rospack find --bogus",
    "rospack list roscpp",
    "rospack depends nope",
    "rospack depends",
    "rospack deps rospy",
    "rospack deps1 rospy",
    "rospack deps-indent rospy",
    "rospack deps-manifests rospy",
    "rospack deps-why --target=genpy roscpp",
    "rospack depends-why --target genpy roscpp",
    "rospack depends-why --target=std_msgs rospy",
    "rospack depends-why --target=roscpp std_msgs",
    "rospack depends-why --target=nope roscpp",
    "rospack depends-why --target=roscpp nope",
    "rospack depends-why roscpp",
    "rospack depends-on std_msgs",
    "rospack depends-on nope",
    "rospack depends-on1 nope",
    "rospack depends-manifests nope",
    "rospack depends-indent nope",
    "rospack rosdep nope",
    "rospack rosdep0 nope",
    "rospack export --lang=cpp --attrib=cflags roscpp",
    "rospack export --lang=cpp roscpp",
    "rospack export --lang=roslang --attrib=cmake roslisp",
    "rospack export --lang=roslang --attrib=cmake nope",
    "rospack plugins --attrib=plugin nodelet",
    "rospack plugins --attrib=plugin --top=topic_tools nodelet",
    "rospack plugins --attrib=plugin nope",
    "rospack plugins nodelet",
    "rospack plugins --attrib=roslaunch rosmaster",
    "rospack libs-only-other roscpp",
    "rospack libs-only-l roscpp",
    "rospack libs-only-l rosconsole",
    "rospack libs-only-l nope",
    "rospack cflags-only-other roscpp",
]


@pytest.mark.parametrize("command", COMMANDS)
def test_output_and_exit_code(environ: dict[str, str], command: str) -> None:
    compare([command.split()], environ)


CATKIN = '<package format="{0}"><name>{1}</name><version>1.2.3</version><description>d</description>{2}</package>'
ODD = {
    "a/package.xml": CATKIN.format(
        2,
        "a",
        "<buildtool_depend>catkin</buildtool_depend><build_depend>bd</build_depend><depend>b</depend>"
        "<depend>std_msgs</depend><exec_depend>c</exec_depend><test_depend>td</test_depend><doc_depend>dd</doc_depend>"
        "<build_export_depend>bed</build_export_depend><buildtool_export_depend>bted</buildtool_export_depend>"
        '<export><b plugin="${prefix}/p.xml" other="x"/><cpp cflags="-I${prefix}/include -DX"/></export>',
    ),
    "b/package.xml": CATKIN.format(
        3,
        "b",
        '<depend condition="$ROS_VERSION == 2">rclcpp</depend><depend>c</depend><exec_depend>roscpp</exec_depend>',
    ),
    "folder_c/package.xml": CATKIN.format(1, "c", "<run_depend>std_msgs</run_depend><!-- <metapackage/> -->"),
    "all/package.xml": CATKIN.format(2, "all", "<exec_depend>a</exec_depend><export><metapackage/></export>"),
    "deep/x/y/dup/package.xml": CATKIN.format(1, "dup", ""),
    "../more/dup/package.xml": CATKIN.format(1, "dup", ""),  # below one folder stock takes any of them
    "ignored/package.xml": CATKIN.format(1, "ignored", ""),
    "ignored/CATKIN_IGNORE": "",
    "a/nested/package.xml": CATKIN.format(1, "nested", ""),
    "stopped/rospack_nosubdirs": "",
    "stopped/inner/package.xml": CATKIN.format(1, "inner", ""),
    "marked/CATKIN_IGNORE": "",
    "marked/inner/package.xml": CATKIN.format(1, "in_marked", ""),
    ".hidden/package.xml": CATKIN.format(1, "hidden", ""),
    "old/manifest.xml": "<package><description brief='x'>d</description><author>A</author><license>BSD</license>"
    "<depend package='older'/><depend package='std_msgs'/><rosdep name='curl'/>"
    "<versioncontrol type='svn' url='http://x/y'/><export><cpp cflags='-I${prefix}/include -DX' "
    "lflags='-L${prefix}/lib -lfoo -Wl,-rpath'/><older plugin='${prefix}/po.xml'/></export></package>",
    "old/msg/A.msg": "int32 a\n",
    "older/manifest.xml": "<package><description>d</description><rosdep name='zlib'/><rosdep name='apr'/><export>"
    "<cpp cflags='-I/older/include -DB' lflags='-L/older/lib -lb -Wl,-x'/></export></package>",
    "older/msg/B.msg": "int32 b\n",
    "stack/stack.xml": "<stack><description>d</description></stack>",
    "stack/one/manifest.xml": "<package><description>d</description></package>",
    "stack/two/manifest.xml": "<package><description>d</description><depend package='one'/></package>",
    "lost/manifest.xml": "<package><description>d</description><depend package='nowhere_at_all'/></package>",
}
ODD_COMMANDS = [
    *(f"rospack {verb} {name}" for name in ("a", "b", "c", "old", "all", "two") for verb in (
        "find", "depends", "depends1", "depends-indent", "depends-manifests", "depends-on", "depends-on1",
        "rosdep", "rosdep0")),
    *(f"rospack find {name}" for name in ("dup", "ignored", "nested", "inner", "in_marked", "hidden", "folder_c",
        "one")),
    "rospack list",
    "rospack list-duplicates",
    "rospack depends lost",
    "rospack export --lang=cpp --attrib=cflags old",
    "rospack export --lang=cpp --attrib=cflags a",
    "rospack export --deps-only --lang=cpp --attrib=cflags old",
    "rospack plugins --attrib=plugin b",
    "rospack plugins --attrib=plugin --top=a b",
    "rospack plugins --attrib=plugin --top=c b",
    "rospack plugins --attrib=plugin older",
    "rospack depends-why --target=std_msgs a",
    "rospack libs-only-l older",
    "rospack libs-only-other older",
    "rospack cflags-only-other older",
]  # fmt: skip


@pytest.fixture
def odd(environ: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    for name, text in ODD.items():
        file = tmp_path / "src" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{tmp_path / 'src'}:{tmp_path / 'more'}")
    return dict(os.environ)


@pytest.mark.parametrize("command", ODD_COMMANDS)
def test_odd_packages(odd: dict[str, str], command: str) -> None:
    compare([command.split()], odd)


@pytest.mark.parametrize("folder", ["a", "a/nested", "old", "old/msg", "deep/x"])
def test_without_a_package_that_of_the_current_folder_is_meant(
    odd: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, folder: str
) -> None:
    here = tmp_path / "src" / folder
    monkeypatch.chdir(here)
    compare([["rospack", "find"], ["rospack", "depends1"], ["rospack", "rosdep0"]], odd, here)
