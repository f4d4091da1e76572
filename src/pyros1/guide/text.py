"""The steps of the guide, which are files in Markdown.

In a step's ``console`` blocks a line with ``$`` is a command, and what follows is what it prints; ``...`` stands for
lines that are left out, ``^C`` for the key. A block with a file's name after its language is a file that the reader
makes.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

STEPS = Path(__file__).parent / "steps"
_BOLD, _RESET = "\x1b[1m", "\x1b[0m"
_CODE = re.compile(r"(?ms)^```(?P<language>\w+)(?: (?P<file>\S+))?\n(?P<text>.*?)^```$")
_BREAK = re.compile(r"\n\s*\n|\n(?=- )")
_MARKS = {"# ": "title", "## ": "heading", "- ": "item"}


class Block(NamedTuple):
    """A part of a step.

    Attributes:
        kind: "title", "heading", "paragraph", "item" (of a list) or "code".
        text: in code as it is typed or printed; else one line, in which `code` and *words* may be marked.
        language: of code: "console", "python", "xml" or "text".
        file: name of the file that the reader makes of this code; empty if it is none.
    """

    kind: str
    text: str
    language: str = ""
    file: str = ""


class GuideStep(NamedTuple):
    """A step of the guide.

    Attributes:
        number: from 1 up.
        name: a word that stays if the number changes.
        title: its heading.
        text: all of it, in Markdown.
    """

    number: int
    name: str
    title: str
    text: str

    @property
    def files(self) -> dict[str, str]:
        """The files that the reader makes: name -> content."""
        return {block.file: block.text for block in self.blocks if block.file}

    @property
    def exercise(self) -> str:
        """The text of its exercise."""
        return self.text.partition("## Exercise\n")[2].strip()

    @property
    def blocks(self) -> list[Block]:
        """Its parts, in their order."""
        found: list[Block] = []
        position = 0
        for fence in _CODE.finditer(self.text):
            found.extend(_prose(self.text[position : fence.start()]))
            found.append(Block("code", fence["text"], fence["language"], fence["file"] or ""))
            position = fence.end()
        return [*found, *_prose(self.text[position:])]


def _prose(text: str) -> Iterator[Block]:
    for part in _BREAK.split(text.strip()):
        line = " ".join(map(str.strip, part.splitlines()))
        mark = next((mark for mark in _MARKS if line.startswith(mark)), "")
        if line:
            yield Block(_MARKS.get(mark, "paragraph"), line.removeprefix(mark))


def steps() -> list[GuideStep]:
    """Return all steps, in their order."""
    found = []
    for path in sorted(STEPS.glob("*.md")):
        text = path.read_text(encoding="utf-8")
        number, _, name = path.stem.partition("-")
        found.append(GuideStep(int(number), name, text.partition("\n")[0].lstrip("# "), text))
    return found


def for_terminal(step: GuideStep, width: int, colour: bool) -> str:
    """Return a step as a terminal shows it.

    Args:
        step: the step.
        width: of the terminal, in columns.
        colour: whether commands and headings are set off with escape sequences.
    """

    def strong(text: str) -> str:
        return f"{_BOLD}{text}{_RESET}" if colour else text

    lines: list[str] = []
    before = ""
    for block in step.blocks:
        if before and (before, block.kind) != ("item", "item"):
            lines.append("")
        before = block.kind
        if block.kind == "title":
            lines.append(strong(f"{step.number}. {block.text}"))
        elif block.kind == "heading":
            lines.append(strong(block.text))
        elif block.kind == "code":
            lines.extend([strong(f"    {block.file}:")] * bool(block.file))
            lines.extend("    " + (strong(line) if line.startswith("$ ") else line) for line in block.text.splitlines())
        else:
            text = re.sub(r"\*(\w[^*]*)\*", r"\1", block.text).replace("`", "")
            dash, rest = ("- ", "  ") if block.kind == "item" else ("", "")
            lines.extend(
                textwrap.wrap(text, width, initial_indent=dash, subsequent_indent=rest, break_on_hyphens=False)
            )
    return "\n".join(lines) + "\n"
