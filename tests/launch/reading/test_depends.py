"""The packages that launch files need, and those that package.xml does not declare (L174, L175)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from pyros1.ground.errors import LaunchError
from pyros1.launch.reading.depends import FileNeeds, declared_depends, file_needs, find_undeclared, package_containing
from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.system_resources import make_resources

MANIFEST = "<package format='2'><name>{}</name><version>1.0.0</version>{}</package>"


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str, str], Path]:
    """Return a function that writes a file below the workspace."""

    def write(path: str, text: str) -> Path:
        file = tmp_path / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        return file

    return write


def needs_of(file: Path) -> list[FileNeeds]:
    return file_needs(load_plan([str(file)], {}, make_resources()))


def node(package: str, type: str = "x", name: str = "n") -> str:
    return f'<node pkg="{package}" type="{type}" name="{name}"/>\n'


def test_nodes_and_tests_in_the_order_of_their_lines(write: Callable[[str, str], Path]) -> None:
    write("mine/package.xml", MANIFEST.format("mine", ""))
    text = (
        node("b", "x", "n1")
        + '<test pkg="c" type="check" test-name="t"/>\n'
        + node("a")
        + node("b", "y", "n2")
        + node("b", "x", "n3")
    )
    file = write("mine/launch/a.launch", f"<launch>\n{text}</launch>")
    assert needs_of(file) == [
        FileNeeds(str(file), "mine", [("b", "x"), ("c", "check"), ("a", "x"), ("b", "y")], ["b", "c", "a"])
    ]


def test_included_files_need_for_themselves_and_their_package_is_needed(write: Callable[[str, str], Path]) -> None:
    write("mine/package.xml", MANIFEST.format("mine", ""))
    write("other/manifest.xml", "<package/>")
    theirs = write("other/b.launch", f"<launch>{node('deep')}</launch>")
    near = write("mine/near.launch", f'<launch>{node("deep", name="n1")}<include file="{theirs}"/></launch>')
    loose = write("loose.launch", "<launch/>")
    includes = [f'<include file="{each}" ns="g{n}"/>' for n, each in enumerate((near, theirs, theirs, loose))]
    file = write("mine/a.launch", f"<launch>{''.join(includes)}</launch>")
    found = {Path(each.file).name: each for each in needs_of(file)}
    assert list(found) == ["a.launch", "near.launch", "b.launch", "loose.launch"]
    assert (found["a.launch"].nodes, found["a.launch"].packages) == ([], ["other"])
    assert (found["near.launch"].packages, found["b.launch"].packages) == (["deep", "other"], ["deep"])
    assert (found["b.launch"].package, found["loose.launch"].package) == ("other", None)


def test_the_package_of_a_file(write: Callable[[str, str], Path]) -> None:
    write("new/package.xml", MANIFEST.format("named", ""))
    write("old/manifest.xml", "<package/>")
    assert package_containing(str(write("new/launch/deep/a.launch", ""))) == "named"
    assert package_containing(str(write("old/a.launch", ""))) == "old", "its folder's name"
    assert package_containing(str(write("none/a.launch", ""))) is None


DEPENDS = (
    "<depend>both</depend><build_depend>build</build_depend><exec_depend> run </exec_depend>"
    "<run_depend>old</run_depend><test_depend>test</test_depend><depend package='very_old'/><depend/>"
)


def test_declared_dependencies(write: Callable[[str, str], Path], tmp_path: Path) -> None:
    folder = write("mine/package.xml", MANIFEST.format("mine", DEPENDS)).parent
    assert declared_depends(folder) == ["both", "very_old", "", "run", "old"]
    assert declared_depends(folder, test_depends=True) == ["both", "very_old", "", "run", "old", "test"]
    assert declared_depends(tmp_path) == []


@pytest.mark.parametrize(
    "text",
    [
        "<package>",
        "",
        "<?xml version='1.0' encoding='no-such'?><package/>",
        "<!DOCTYPE p [<!ENTITY a 'b'>]><package>&a;</package>",
    ],
)
def test_a_manifest_that_cannot_be_read_is_named(write: Callable[[str, str], Path], text: str) -> None:
    path = write("mine/package.xml", text)
    with pytest.raises(LaunchError, match="cannot read") as caught:
        declared_depends(path.parent)
    assert str(path) in str(caught.value)


def test_what_is_not_declared(write: Callable[[str, str], Path]) -> None:
    write("mine/package.xml", MANIFEST.format("mine", "<exec_depend>run</exec_depend><test_depend>test</test_depend>"))
    files = [str(write(f"mine/{name}.launch", "")) for name in ("a", "b")]
    needs = [
        FileNeeds("/no/where.launch", None, packages=["unheard"]),
        FileNeeds(files[0], "mine", packages=["run", "mine", "test", "new"]),
        FileNeeds(files[1], "mine", packages=["new", "newer"]),
    ]
    assert find_undeclared(needs) == {"mine": ["test", "new", "newer"]}
    assert find_undeclared(needs, test_depends=True) == {"mine": ["new", "newer"]}
    assert find_undeclared(needs[:1]) == {}
