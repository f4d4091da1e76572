"""The parts of the guide's steps, and how a terminal shows them."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest

from pyros1.guide.documents import Block, GuideStep, format_for_terminal, steps

STEP = """# A step

Two lines
of *text* with `code`.

## Type

```console
$ ls
# not a heading

- not an item
```

- one
- two
  lines
```python a/b.py
x = 1
```
"""


def test_the_parts_of_a_step() -> None:
    step = GuideStep(3, "step", "A step", STEP)
    assert step.blocks == [
        Block("title", "A step"),
        Block("paragraph", "Two lines of *text* with `code`."),
        Block("heading", "Type"),
        Block("code", "$ ls\n# not a heading\n\n- not an item\n", "console"),
        Block("item", "one"),
        Block("item", "two lines"),
        Block("code", "x = 1\n", "python", "a/b.py"),
    ]
    assert step.files == {"a/b.py": "x = 1\n"}
    shown = format_for_terminal(step, 20, colour=False).splitlines()
    assert shown[:5] == ["3. A step", "", "Two lines of text", "with `code`.", ""]
    assert "\x1b[1m3. A step\x1b[0m" in format_for_terminal(step, 20, colour=True)


def test_commands_in_prose_are_marked() -> None:
    step = GuideStep(1, "s", "S", "# S\n\nType `pyros1 topic list` now.\n\n| `a` | b |\n|---|---|\n| `c d` | `e` |\n")
    bold = format_for_terminal(step, 17, colour=True)
    assert "Type \x1b[1mpyros1\x1b[0m\n\x1b[1mtopic list\x1b[0m now." in bold
    assert "\x1b[1ma    b\x1b[0m\n\x1b[1mc d\x1b[0m  \x1b[1me\x1b[0m\n" in bold
    assert "`a`    b\n`c d`  `e`\n" in format_for_terminal(step, 17, colour=False)


@pytest.mark.parametrize("seed", range(50))
def test_no_word_is_lost(seed: int) -> None:
    chance = random.Random(seed)
    lines = [
        "",
        "word",
        "- item",
        "## Heading",
        "```console",
        "```",
        "$ command",
        "*x* `y`",
        "  more",
        "```python f.py",
    ]
    text = "".join(f"{chance.choice(lines)}\n" for _ in range(chance.randrange(20)))
    blocks = GuideStep(1, "x", "x", text).blocks
    for word in ("word", "item", "Heading", "command", "more", "*x* `y`"):
        assert sum(block.text.count(word) for block in blocks) == text.count(word)


def test_steps_are_numbered_and_named_once_each() -> None:
    known = steps()
    assert [step.number for step in known] == list(range(1, len(known) + 1))
    assert len({step.name for step in known}) == len(known)
    for step in known:
        assert [block.text for block in step.blocks if block.kind == "title"] == [step.title]
        assert [block.text for block in step.blocks if block.kind == "heading"][-1] == "Exercise"
        assert step.text.endswith(f"\n\n`pyros1 guide check {step.number}` checks whether it is done.\n")


def test_the_page_has_panels_for_steps_that_there_are() -> None:
    folder = Path(__file__).parents[2] / "src" / "pyros1" / "web" / "page" / "panels"
    beside = re.search(r"const PANELS_BESIDE = \{\n(.*?)\n\};", (folder / "guide.js").read_text(encoding="utf-8"), re.S)
    assert beside is not None
    named = set(re.findall(r"^  (\w+): \[", beside[1], re.M))
    assert len(named) > 5 and named <= {step.name for step in steps()}
    assert all((folder / f"{panel}.js").is_file() for panel in re.findall(r'\["(\w+)", "', beside[1]))


def test_pictures_are_shown_on_the_page_and_are_small() -> None:
    found = [block for step in steps() for block in step.blocks if block.kind == "picture"]
    page = Path(__file__).parents[2] / "src" / "pyros1" / "web" / "page"
    files = [page / block.file for block in found]
    assert len(files) > 4 and {*files} == {*(page / "pictures").iterdir()}
    assert sum(file.stat().st_size for file in files) < 300_000
    look = steps()[2]
    assert found[0].text not in format_for_terminal(look, 100, colour=False)
    assert not any("![" in block.text for step in steps() for block in step.blocks if block.kind != "code")
