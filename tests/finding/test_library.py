"""Where definitions come from (G28)."""

from __future__ import annotations

from pathlib import Path

import pytest

from pyros1.finding.library import Library
from pyros1.ground.errors import DefinitionError, UnknownTypeError


def write(path: Path, data: str | bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data.encode() if isinstance(data, str) else data)


def package(folder: Path) -> Path:
    write(folder / "package.xml", f"<package><name>{folder.name}</name></package>")
    return folder


@pytest.fixture
def library(tmp_path: Path) -> Library:
    ws = package(tmp_path / "ws/src/deep/pkg")
    write(ws / "msg/A.msg", "int8 from_workspace")
    write(ws / "msg/Bad.msg", "int8 ok\nwrong\n")
    write(ws / "msg/Lines.msg", b"int8 a\r\nstring X=b\rint8 c # \xe9\n")
    write(ws / "srv/S.srv", "A a\n---\n")
    write(ws / "action/Do.action", "A a\n---\n---\n")
    for kind, root in (("stock", tmp_path / "stock/pkg"), ("shipped", tmp_path / "shipped/pkg")):
        for name in ("A", "B") if kind == "stock" else ("A", "B", "C"):
            write(root / f"msg/{name}.msg", f"int8 from_{kind}")
    write(tmp_path / "shipped/other/srv/T.srv", "---\n")
    environ = {"ROS_PACKAGE_PATH": str(tmp_path / "ws/src")}
    return Library(environ, installs=[tmp_path / "stock"], shipped=tmp_path / "shipped")


def test_g28_workspace_then_stock_then_shipped_file_by_file(library: Library) -> None:
    for name, origin in (("A", "workspace"), ("B", "stock"), ("C", "shipped")):
        assert library.message(f"pkg/{name}").fields[0].name == f"from_{origin}"
    assert library.message("pkg/A") is library.message("pkg/A")


def test_services_and_actions(library: Library) -> None:
    assert library.service("pkg/S").request.fields[0].type == "pkg/A"
    assert library.message("pkg/DoAction").fields[0].type == "pkg/DoActionGoal"
    assert library.message("pkg/DoActionGoal").fields[2].type == "pkg/DoGoal"
    assert library.message("pkg/DoGoal").fields[0].type == "pkg/A"


def test_lists(library: Library) -> None:
    assert {"other", "pkg"} <= set(library.packages())
    assert library.messages("pkg")[:4] == ["A", "B", "Bad", "C"]
    assert "DoActionFeedback" in library.messages("pkg")
    assert (library.services("pkg"), library.services("other")) == (["S"], ["T"])
    assert library.has_package("other") and not library.has_package("none")


def test_line_ends_and_foreign_bytes(library: Library) -> None:
    spec = library.message("pkg/Lines")
    assert spec.text == "int8 a\nstring X=b\nint8 c # é\n"
    assert [field.name for field in spec.fields] == ["a", "c"]


def test_errors(library: Library) -> None:
    with pytest.raises(DefinitionError, match=r"pkg/msg/Bad\.msg:2: "):
        library.message("pkg/Bad")
    with pytest.raises(UnknownTypeError, match=r"\[pkg/Nope\] is unknown; package \[pkg\] has A, B, "):
        library.message("pkg/Nope")
    with pytest.raises(UnknownTypeError, match=r"no package \[none\] with definitions; is ROS_PACKAGE_PATH set"):
        library.service("none/Nope")
    assert (
        Library({}).missing_package_message("std_msg").endswith("(did you mean 'std_msgs'?); is ROS_PACKAGE_PATH set?")
    )
    assert (
        Library({"ROS_PACKAGE_PATH": "/ws"}).missing_package_message("std_msg").endswith("(did you mean 'std_msgs'?)")
    )
    for name in ("A", "", "pkg/", "pkg/../A", "/A", "pkg/A/B", "../pkg/A"):
        with pytest.raises(UnknownTypeError, match="package/Type"):
            library.message(name)
