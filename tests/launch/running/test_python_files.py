"""Programs in Python that cannot run, found without running them.

Feature: `pyros1 launch --check` finds problems before anything starts
"""

from __future__ import annotations

import os
import sys
import threading
from pathlib import Path
from types import SimpleNamespace

import pytest

from pyros1.launch.running.python_files import Import, find_imports, python_problems

OURS = f"#!{sys.executable}\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "beside.py").write_text("raise SystemExit('it was executed')\n")
    return tmp_path


def problems(folder: Path, text: str, **environ: str) -> list[str]:
    """Return what is said of a program, without the program's path."""
    file = folder / "node"
    file.write_text(text)
    return [each.text.replace(str(file), "FILE") for each in python_problems({file: {**os.environ, **environ}})]


def test_what_can_run(folder: Path) -> None:
    text = "import os, beside, rospy\nimport xml.dom\nfrom std_msgs.msg import String\nfrom . import other\n"
    text += "try:\n    import nothing_a\nexcept ImportError:\n    pass\ndef run():\n    import nothing_b\n"
    text += "if os.environ.get('HERE'):\n    import nothing_c\nraise SystemExit('it was executed')\n"
    assert problems(folder, OURS + text) == []


def test_modules_that_are_not_installed(folder: Path) -> None:
    text = "import os, nothing_a.part as a\nfrom nothing_b.msg import X\nimport nothing_a\n"
    text += "if __name__ == '__main__':\n    import nothing_c\n"
    assert problems(folder, OURS + text) == [
        f"FILE:{line}: {sys.executable} cannot find module {name}"
        for line, name in ((2, "nothing_a"), (3, "nothing_b"), (6, "nothing_c"))
    ]


def test_the_nodes_own_environment_counts(folder: Path) -> None:
    (folder / "more").mkdir()
    (folder / "more" / "nothing_a.py").touch()
    assert problems(folder, OURS + "import nothing_a\n", PYTHONPATH=str(folder / "more")) == []


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("print 'a'\n", "FILE:2: Missing parentheses in call to 'print'"),
        ("try:\n    pass\nexcept A, e:\n    pass\n", "FILE:4: "),
        ("x = 0777\n", "FILE:2: leading zeros in decimal"),
    ],
)
def test_programs_for_python_2(folder: Path, text: str, said: str) -> None:
    (found,) = problems(folder, "#!/usr/bin/env python\n" + text)
    assert found.startswith(said) and "pip install fissix && fissix -w FILE" in found


def test_other_errors_of_syntax(folder: Path) -> None:
    (found,) = problems(folder, OURS + "a b\n")
    assert found == "FILE:2: invalid syntax"
    (found,) = problems(folder, OURS + "x = '\\0'\n\0\n")
    assert found.startswith("FILE") and "null bytes" in found


@pytest.mark.parametrize("first", ["#!/bin/sh", "#!/usr/bin/env python2", "#!/usr/bin/python2.7", "", "\x7fELF"])
def test_other_programs(folder: Path, first: str) -> None:
    assert problems(folder, first + "\nprint 'a'\nimport nothing_a\n") == []


def test_a_python_that_is_not_there(folder: Path) -> None:
    assert problems(folder, "#!/nowhere/python3\nimport nothing_a\n") == []
    assert [*python_problems({folder / "nothing": os.environ})] == []


def test_imports_that_are_always_made() -> None:
    assert [tuple(each) for each in find_imports(b"import a.b, c\nfrom d.e import f\nfrom .g import h\n")] == [
        ("a", 1),
        ("c", 1),
        ("d", 2),
    ]


def bare(folder: Path, *offered: str) -> str:
    """Return the first line of a program whose Python has no pyros1, but empty modules of the names offered."""
    search = folder / "search"
    search.mkdir()
    for name in offered:
        (search / f"{name}.py").touch()
    python = folder / "python3"
    python.write_text(f'#!/bin/sh\nexport PYTHONPATH={search}\nexec {sys.executable} -S "$@"\n')
    python.chmod(0o755)
    return f"#!{python}\n"


def test_a_python_without_pyros1(folder: Path) -> None:
    first = bare(folder)
    found = problems(folder, first + "import rospy, nothing_a, pyros1, std_msgs.msg, minimal_nodes\n")
    assert [line.partition(" cannot find module ")[2].partition(": ")[0] for line in found] == [
        "rospy", "nothing_a", "pyros1", "std_msgs", "minimal_nodes",
    ]  # fmt: skip
    activate = Path(sys.executable).with_name("activate")
    cure = f"write #!{sys.executable} as the program's first line"
    if activate.is_file():
        cure = f"activate pyros1's environment first (source {activate}), or {cure}"
    assert [line.endswith(f": {cure}") for line in found] == [True, False, True, True, True]


def test_a_python_with_pyros1_that_lacks_a_module_needs_another_cure(folder: Path) -> None:
    (found,) = problems(folder, bare(folder, "pyros1") + "import rospy\n")
    assert found.endswith("cannot find module rospy")


@pytest.mark.slow
def test_more_imports_than_fit_into_an_argument(folder: Path) -> None:
    names = [f"nothing_{number}_{'x' * 60}" for number in range(2000)]
    found = problems(folder, OURS + "".join(f"import {name}\n" for name in names))
    assert len(found) == 2000 and found[-1].endswith(names[-1])


@pytest.mark.parametrize(
    "deep", ["-" * 100_000 + "1", "not " * 100_000 + "1", "1" + "+1" * 200_000, "a" + ".b" * 200_000]
)
def test_source_that_is_too_deep(folder: Path, deep: str) -> None:
    found = problems(folder, f"{OURS}import os\nx = {deep}\n")
    if sys.version_info < (3, 11) and not found:
        return  # chains of operators have no limit there
    assert found == ["FILE: its expressions or blocks are nested too deeply for Python"]


def test_source_that_python_just_reads(folder: Path) -> None:
    assert problems(folder, f"{OURS}if 0{'+1' * 1500}:\n    import nothing_a\n") == []


@pytest.fixture(params=[(3, 10), (3, 11)])
def parser(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Parse as on Python 3.10, which needs a large stack, and as on later ones."""
    monkeypatch.setattr("pyros1.launch.running.python_files.sys", SimpleNamespace(version_info=request.param))


@pytest.mark.usefixtures("parser")
def test_source_is_parsed_alike_with_every_python() -> None:
    stack_size = threading.stack_size()
    assert find_imports(b"import a\n") == [Import("a", 1)]
    with pytest.raises(SyntaxError, match="invalid syntax"):
        find_imports(b"a b\n")
    assert threading.stack_size() == stack_size


def test_programs_of_pyros1_are_not_looked_at(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.launch.running.command_line.OWN_PACKAGES", os.path.realpath(folder))
    assert problems(folder, OURS + "a b\n") == []
