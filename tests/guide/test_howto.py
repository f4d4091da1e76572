"""The how-to pages: what they link to is there, and their code is run by tests.

Feature: how-to pages -- `pyros1 guide howto NAME`; tests run their programs
"""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from xml.etree import ElementTree

import pytest

from pyros1.cli import registry
from pyros1.guide.documents import HOWTO_FOLDER, GuidePage, format_for_terminal, pages, parse_blocks, remove_markup

ROOT = Path(__file__).resolve().parents[2]
PAGES = pages()
README = GuidePage("README", "pyros1", (ROOT / "README.md").read_text(encoding="utf-8"))


def test_tables_and_links() -> None:
    page = GuidePage("x", "X", "# X\n\n| a | `b` | |\n|---|---|---|\n| 1 | 2 \\| 3 | |\n| [c](y.md) | | <http://z> |\n")
    title, table = page.blocks
    assert title.text == "X"
    assert table.rows == (("a", "`b`", ""), ("1", "2 | 3", ""), ("[c](y.md)", "", "<http://z>"))
    wide = format_for_terminal(page, 80, colour=False).splitlines()
    assert wide == [
        "X",
        "",
        "a                         `b`",
        "1                         2 | 3",
        "c (pyros1 guide howto y)         http://z",
    ]
    narrow = format_for_terminal(page, 30, colour=False).splitlines()
    assert narrow[2:] == ["- 1", "  `b`: 2 | 3", "- c (pyros1 guide howto y)", "  http://z"]


def test_pictures_and_comments_are_not_shown() -> None:
    pictures = "| | |\n|---|---|\n| ![p](x/q.png) | |\n"
    text = f"a\n\n{pictures}\n<!-- made -->\n| h |\n|---|\n| c |\n<!-- end -->\n![r](x/s.png)\n"
    assert [block.kind for block in parse_blocks(text)] == ["paragraph", "table"]


def test_marks_in_a_line() -> None:
    assert remove_markup("*so* `*x*` and [`t`](http://u/v), [w](../w.py)") == "so `*x*` and `t` (http://u/v), w"


@pytest.mark.parametrize("page", PAGES.values(), ids=PAGES)
def test_a_page_in_a_terminal(page: GuidePage) -> None:
    shown = format_for_terminal(page, 80, colour=False)
    assert shown.startswith(f"{page.heading}\n\n")
    code = {line.strip() for block in page.blocks if block.kind == "code" for line in block.text.splitlines()}
    for line in shown.splitlines():
        assert line.strip() in code or not re.search(r"^\||\]\(|<!--|##", line), line


def test_readme_has_all_pages() -> None:
    listed = re.findall(r"^\| \[(.*?)\]\(src/pyros1/guide/howto/(\w+)\.md\) \| \S.* \|$", README.text, re.M)
    assert sorted(listed) == sorted((page.heading, name) for name, page in PAGES.items())


@pytest.mark.parametrize("page", [README, *PAGES.values()], ids=["README", *PAGES])
def test_links_lead_somewhere(page: GuidePage) -> None:
    folder = ROOT if page is README else HOWTO_FOLDER
    for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"(?ms)^```.*?^```$", "", page.text)):
        assert target.startswith("https://") or (folder / target).exists(), target


def test_programs_are_run_by_tests() -> None:
    tests = [path for name in ("tests", "interop") for path in (ROOT / name).rglob("test_*.py")]
    used = {name for path in tests for name in re.findall(r'pages\(\)\["(\w+)"\]', path.read_text(encoding="utf-8"))}
    assert {name for name, page in PAGES.items() if page.code("python")} <= used


@pytest.mark.parametrize("page", [README, *PAGES.values()], ids=["README", *PAGES])
def test_commands_and_launch_files(page: GuidePage) -> None:
    for text in page.code("xml"):
        assert ElementTree.fromstring(text).tag == "launch"
    typed = [
        line.partition("$ ")[2] for line in "".join(page.code("console")).splitlines() if re.match(r"\w*\$ ", line)
    ]
    typed += [line for language in ("sh", "bash") for line in "".join(page.code(language)).splitlines()]
    for line in typed:
        for command in re.findall(r"^(?!docker).*?\bpyros1 ([^;&|)#]+)", line):
            name, *words = shlex.split(command)
            assert name in registry.commands(), line
            verbs = registry.verbs(name)
            may_be_left_out = registry.load_command(name).dispatch is not None and words[0].startswith("--")
            assert not verbs or words[0] in verbs or may_be_left_out, line
