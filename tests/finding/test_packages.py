"""PackageIndex: the places, their order, resources and executables (G28)."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from pyros1.finding.crawl import all_packages
from pyros1.finding.packages import PackageIndex
from pyros1.ground.errors import PackageNotFoundError

NAMES_BELOW = """
import resource, sys
from pyros1.finding.packages import PackageIndex
from pyros1.finding.crawl import read_identity
resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))
index = PackageIndex({"ROS_PACKAGE_PATH": sys.argv[1]}, installs=[], own=sys.argv[1] + "/none")
print(index.list(), sorted(read_identity(f"{sys.argv[1]}/{name}", "package.xml")[0] for name in index.list()))
"""


def make_package(folder: Path, name: str | None = None) -> Path:
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text(f"<package format='2'>\n <name> {name or folder.name} </name></package>")
    return folder


def index(tmp_path: Path, *roots: str, prefixes: str = "") -> PackageIndex:
    path = ":".join(str(tmp_path / root) for root in roots)
    return PackageIndex(
        {"ROS_PACKAGE_PATH": path, "CMAKE_PREFIX_PATH": prefixes},
        installs=[tmp_path / "stock" / "share"],
        own=tmp_path / "own",
    )


def test_g28_package_path_before_stock_before_own(tmp_path: Path) -> None:
    for place in ("ws/src", "stock/share", "own"):
        make_package(tmp_path / place / "a")
    for place in ("stock/share", "own"):
        make_package(tmp_path / place / "b")
    make_package(tmp_path / "own" / "c")
    packages = index(tmp_path, "ws/src")
    assert packages.find("a") == tmp_path / "ws/src/a"
    assert packages.find("b") == tmp_path / "stock/share/b"
    assert packages.find("c") == tmp_path / "own/c"
    assert packages.list() == ["a", "b", "c"]


def test_g28_crawl_finds_deep_packages_by_their_declared_name(tmp_path: Path) -> None:
    deep = make_package(tmp_path / "ws/x/y/folder", name="real_name")
    make_package(deep / "nested")  # packages do not nest
    ignored = make_package(tmp_path / "ws/x/ignored")
    (ignored / "CATKIN_IGNORE").touch()
    make_package(tmp_path / "ws/.hidden/secret")
    old = tmp_path / "ws/old"
    old.mkdir()
    (old / "manifest.xml").write_text("<package/>")
    packages = index(tmp_path, "ws")
    assert packages.find("real_name") == deep
    assert packages.list() == ["old", "real_name"]
    for name in ("folder", "nested", "ignored", "secret", "", "../ws", ".", "a\0b", "\ud800"):
        with pytest.raises(PackageNotFoundError):
            packages.find(name)


def test_g28_earlier_root_wins_and_a_root_may_be_a_package(tmp_path: Path) -> None:
    first = make_package(tmp_path / "one/deep/p")
    make_package(tmp_path / "two/p")
    single = make_package(tmp_path / "single")
    packages = index(tmp_path, "one", "two", "single", "missing")
    assert packages.find("p") == first
    assert packages.find("single") == single


def test_of_one_name_the_first_in_the_order_of_folders_counts(tmp_path: Path) -> None:
    first = make_package(tmp_path / "ws/backup/p")
    make_package(tmp_path / "ws/src/p")
    assert index(tmp_path, "ws").paths()["p"] == index(tmp_path, "ws").find("p") == first


def test_of_one_name_the_one_directly_in_the_folder_counts(tmp_path: Path) -> None:
    """Both for who asks for one package, and so does not look at all others, and for who asks for all."""
    make_package(tmp_path / "ws/backup/p")
    direct = make_package(tmp_path / "ws/p")
    make_package(tmp_path / "ws/backup/q")
    make_package(tmp_path / "ws/another", name="q")
    roots = [(str(tmp_path / "ws"), 5)]
    environ = {"ROS_PACKAGE_PATH": str(tmp_path / "ws"), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    for name, folder in (("p", direct), ("q", tmp_path / "ws/another")):
        assert index(tmp_path, "ws").paths()[name] == index(tmp_path, "ws").find(name) == folder
        assert next(found.folder for found in all_packages(environ, roots=roots) if found.name == name) == str(folder)


@pytest.mark.parametrize("way", ["stock/share/.", "./stock//share/", "stock/./share/./"])
def test_needless_dots_and_slashes_mean_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, way: str) -> None:
    make_package(tmp_path / "stock/share/p")
    program = tmp_path / "stock/lib/p/prog"
    program.parent.mkdir(parents=True)
    program.touch(mode=0o755)
    monkeypatch.chdir(tmp_path)
    for root in (way, str(tmp_path) + "/" + way):
        packages = PackageIndex({"ROS_PACKAGE_PATH": root}, installs=[], own=tmp_path / "own")
        assert packages.find("p").resolve() == tmp_path / "stock/share/p"
        assert [path.resolve() for path in packages.find_executable("p", "prog")] == [program]
        assert packages.executables("p") == ["prog"]
        assert str(packages.search_folders()[0][0]) == str(Path(root))


def test_a_package_whose_folder_is_searched_by_a_dot_has_its_name(tmp_path: Path) -> None:
    folder = tmp_path / "manif"
    folder.mkdir()
    (folder / "manifest.xml").write_text("<package/>")
    assert PackageIndex({"ROS_PACKAGE_PATH": f"{folder}/."}, installs=[], own=tmp_path / "own").list() == ["manif"]


def test_a_package_directly_in_a_folder_is_found_without_a_look_at_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wanted = make_package(tmp_path / "ws/p")
    make_package(tmp_path / "ws/other/q")
    packages = index(tmp_path, "ws")
    monkeypatch.setattr("os.scandir", lambda folder: pytest.fail(f"{folder} is read"))
    assert packages.find("p") == wanted


@pytest.mark.parametrize("mark", ["CATKIN_IGNORE", "package.xml", "p/CATKIN_IGNORE"])
def test_a_package_that_a_crawl_passes_over_is_not_found_directly_either(tmp_path: Path, mark: str) -> None:
    make_package(tmp_path / "ws/p")
    (tmp_path / "ws" / mark).write_text("")
    packages = index(tmp_path, "ws")
    assert "p" not in packages.paths()
    with pytest.raises(PackageNotFoundError):
        packages.find("p")


def test_links_that_lead_back_end(tmp_path: Path) -> None:
    make_package(tmp_path / "ws/p")
    for name in ("loop", "another", "third"):
        (tmp_path / "ws" / name).symlink_to(tmp_path / "ws")
    assert index(tmp_path, "ws").list() == ["p"]


def test_links_between_many_folders_are_crawled_once(tmp_path: Path) -> None:
    for i in range(15):
        (tmp_path / f"ws/f{i}").mkdir(parents=True)
        for j in range(15):
            (tmp_path / f"ws/f{i}" / f"to{j}").symlink_to(tmp_path / f"ws/f{j}")
    make_package(tmp_path / "ws/f7/p")
    packages = index(tmp_path, "ws")
    assert packages.list() == ["p"]
    assert packages.find("p").samefile(tmp_path / "ws/f7/p")
    environ = {"ROS_PACKAGE_PATH": str(tmp_path / "ws"), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    found = all_packages(environ, roots=[(str(tmp_path / "ws"), 20)])
    assert {package.name for package in found} == {"p"}


def test_names_in_comments_do_not_count(tmp_path: Path) -> None:
    folder = make_package(tmp_path / "ws/folder", name="yes")
    file = folder / "package.xml"
    file.write_text(file.read_text().replace("<name>", "<!-- <name>no</name> --><name>"))
    assert index(tmp_path, "ws").list() == ["yes"]


def test_not_found_names_the_places(tmp_path: Path) -> None:
    with pytest.raises(PackageNotFoundError, match=r"package \[nope\] not found .*ws"):
        index(tmp_path, "ws").find("nope")


def test_resources(tmp_path: Path) -> None:
    package = make_package(tmp_path / "ws/p")
    for place in ("launch", "a/b"):
        (package / place).mkdir(parents=True)
        (package / place / "x.launch").touch()
    packages = index(tmp_path, "ws")
    assert packages.find_resource("p", "x.launch") == [package / "a/b/x.launch", package / "launch/x.launch"]
    assert packages.find_resource("p", "launch/x.launch") == [package / "launch/x.launch"]
    assert packages.find_resource("p", "y.launch") == []
    with pytest.raises(PackageNotFoundError):
        packages.find_resource("q", "x.launch")


def linked_package(tmp_path: Path) -> Path:
    """A package whose folders are links to elsewhere, with links that lead back, to themselves and nowhere."""
    package = make_package(tmp_path / "ws/p")
    elsewhere = tmp_path / "elsewhere"
    for file, mode in (("launch/deep/x.launch", 0o644), ("bin/tool", 0o755), (".git/hook", 0o755)):
        (elsewhere / file).parent.mkdir(parents=True, exist_ok=True)
        (elsewhere / file).touch(mode)
    for name in ("launch", "bin", ".git"):
        (package / name).symlink_to(elsewhere / name)
    (package / "sub").mkdir()
    targets = {"up": "..", "self": ".", "top": tmp_path, "loop": "loop", "nowhere": "/nowhere", "again": "../launch"}
    for name, target in targets.items():
        (package / "sub" / name).symlink_to(target)
    make_package(tmp_path / "ws/q")
    (tmp_path / "ws/q/x.launch").touch()
    (tmp_path / "ws/q/more").symlink_to(package)
    (tmp_path / "ws/loop").symlink_to("loop")
    return package


def test_links_to_folders_in_a_package_are_followed(tmp_path: Path) -> None:
    package = linked_package(tmp_path)
    packages = index(tmp_path, "ws")
    assert packages.list() == ["p", "q"]
    assert packages.find_resource("p", "x.launch") == [package / "launch/deep/x.launch"]
    assert packages.find_executable("p", "tool") == [package / "bin/tool"]
    assert packages.executables("p") == ["tool"]
    assert packages.find_resource("q", "x.launch") == [
        tmp_path / "ws/q/x.launch",
        tmp_path / "ws/q/more/launch/deep/x.launch",
    ]
    environ = {"ROS_PACKAGE_PATH": str(tmp_path / "ws"), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    assert [found.name for found in all_packages(environ)][:2] == ["p", "q"]


def test_links_between_many_folders_are_followed_once(tmp_path: Path) -> None:
    package = make_package(tmp_path / "ws/p")
    for i in range(30):
        (package / f"f{i}").mkdir()
        (package / f"f{i}" / "file").touch()
        for j in range(30):
            (package / f"f{i}" / f"to{j}").symlink_to(package / f"f{j}")
    assert index(tmp_path, "ws").find_resource("p", "file") == sorted(package / f"f{i}/file" for i in range(30))


def test_executables_in_libexec_then_in_the_package(tmp_path: Path) -> None:
    package = make_package(tmp_path / "stock/share/p")
    libexec = tmp_path / "stock/lib/p"
    devel = tmp_path / "devel/lib/p"
    for folder in (libexec, devel, package / "scripts"):
        folder.mkdir(parents=True)
        (folder / "node").touch(mode=0o755)
    (package / "scripts" / "plain").touch(mode=0o644)
    packages = index(tmp_path, prefixes=str(tmp_path / "devel"))
    assert packages.find_executable("p", "node") == [devel / "node", libexec / "node", package / "scripts/node"]
    assert packages.find_executable("p", "plain") == []
    assert packages.find_executable("p", "scripts/node") == [package / "scripts/node"]


def test_own_packages_need_no_executable_bit(tmp_path: Path) -> None:
    package = make_package(tmp_path / "own/minimal")
    (package / "nodes").mkdir()
    (package / "nodes" / "talker.py").touch(mode=0o644)
    packages = index(tmp_path)
    assert packages.find_executable("minimal", "talker") == [package / "nodes/talker.py"]
    assert packages.find_executable("minimal", "talker.py") == [package / "nodes/talker.py"]


def test_programs_that_an_installed_package_lacks_are_pyros1s(tmp_path: Path) -> None:
    """Debian has packages, tf2_ros for one, whose programs are in a package of their own."""
    stock, own = make_package(tmp_path / "stock/share/tf"), make_package(tmp_path / "own/tf")
    for folder, name in ((own, "echo"), (own, "monitor"), (stock, "echo")):
        (folder / name).touch(mode=0o755)
    packages = index(tmp_path)
    assert packages.find("tf") == stock
    assert packages.find_executable("tf", "echo") == [stock / "echo"]
    assert packages.find_executable("tf", "monitor") == [own / "monitor"]
    assert packages.find_executable("tf", "nothing") == []


def test_executables_of_a_package(tmp_path: Path) -> None:
    folder = tmp_path / "share" / "robot"
    for path, mode in (("package.xml", 0o644), ("scripts/run", 0o755), ("scripts/data", 0o644), (".git/hook", 0o755)):
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text("")
        (folder / path).chmod(mode)
    (tmp_path / "lib" / "robot").mkdir(parents=True)
    (tmp_path / "lib" / "robot" / "walk").touch(0o755)
    assert PackageIndex({}, installs=[tmp_path / "share"]).executables("robot") == ["run", "walk"]
    assert "minimal_publisher" in PackageIndex({}, installs=[]).executables("minimal_nodes")


def test_g28_spaces_and_python_packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    in_space, in_share = (
        make_package(tmp_path / "install" / "share" / "one"),
        make_package(tmp_path / "prefix" / "share" / "two"),
    )
    in_python = make_package(tmp_path / "site-packages" / "three")
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "prefix"))
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path / "site-packages")])
    index = PackageIndex({"CMAKE_PREFIX_PATH": str(tmp_path / "install")})
    assert [index.find(name) for name in ("one", "two", "three")] == [in_space, in_share, in_python]


def test_an_executable_that_was_moved_is_found_again(tmp_path: Path) -> None:
    package = make_package(tmp_path / "ws/p")
    packages = index(tmp_path, "ws")
    assert packages.find_executable("p", "run") == []
    for folder in ("one", "two"):
        (package / folder).mkdir()
        (package / folder / "run").touch(0o755)
        assert packages.find_executable("p", "run") == [package / folder / "run"]
        (package / folder / "run").unlink()


@pytest.mark.slow
def test_places_are_named_once_each(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [])
    with pytest.raises(PackageNotFoundError) as error:
        PackageIndex({"ROS_PACKAGE_PATH": "/usr/share"}).find("no_such_package")
    assert str(error.value).count("/usr/share,") == 1


def test_manifests_that_never_end_are_not_read(tmp_path: Path) -> None:
    for name in ("device", "pipe"):
        (tmp_path / "ws" / name).mkdir(parents=True)
    (tmp_path / "ws/device/package.xml").symlink_to("/dev/full")
    os.mkfifo(tmp_path / "ws/pipe/package.xml")
    found = subprocess.run(
        [sys.executable, "-c", NAMES_BELOW, str(tmp_path / "ws")],
        capture_output=True,
        text=True,
        timeout=30,
        check=True,
    )
    assert found.stdout == "['device', 'pipe'] ['device', 'pipe']\n"
