"""The steps of the guide and its how-to pages, which are Markdown files.

In a step's ``console`` blocks a line with ``$`` is a command, followed by its output; ``...`` stands for omitted lines,
``^C`` for the key. A block with a file name after its language is a file that the reader creates. Pages also have
tables and links. Pictures that are files of the web page, each in its own paragraph, are also displayed in the browser;
other pictures only to readers of the files in the repository.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

STEPS = Path(__file__).parent / "steps"
HOWTO = Path(__file__).parent / "howto"
_BOLD, _RESET = "\x1b[1m", "\x1b[0m"
_CODE = re.compile(r"(?ms)^```(?P<language>\w+)(?: (?P<file>\S+))?\n(?P<text>.*?)^```$")
_HIDDEN = re.compile(r"(?m)^<!--.*-->\n|!\[[^\]]*\]\((?![./]+/web/page/)[^)]*\)")
_PICTURE = re.compile(r"!\[(?P<text>[^\]]+)\]\([./]+/web/page/(?P<file>pictures/[\w.]+)\)")
_BREAK = re.compile(r"\n\s*\n|\n(?=- )")
_RULE = re.compile(r"[|:\s-]+")
_BAR = re.compile(r"(?<!\\)\|")
_MARKS = {"# ": "title", "## ": "heading", "- ": "item"}
_INLINE = re.compile(
    r"`(?P<code>[^`]+)`|\*(?P<word>\w[^*]*)\*|\[(?P<label>[^\]]+)\]\((?P<to>[^)]+)\)|<(?P<link>http[^>]+)>"
)
_COMMAND = re.compile(r"`([^`]+)`")
_PAGE = re.compile(r"(\w+)\.md")


class Block(NamedTuple):
    """A part of a step or page.

    Attributes:
        kind: "title", "heading", "paragraph", "item" (of a list), "table", "picture" or "code".
        text: code as typed or printed; otherwise one line, with markup for `code`, *words* and [links](x.md).
        language: language of code: "console", "python", "xml", "text" and others.
        file: name of the file that the reader creates from this code; for a picture, its path in the page. Else empty.
        rows: cell texts of a table, whose text is empty; the first row is its header, whose cells may be empty.
    """

    kind: str
    text: str
    language: str = ""
    file: str = ""
    rows: tuple[tuple[str, ...], ...] = ()


class GuideStep(NamedTuple):
    """A step of the guide.

    Attributes:
        number: its number, starting at 1.
        name: a name that stays the same if the number changes.
        title: its heading.
        text: all of it, in Markdown.
    """

    number: int
    name: str
    title: str
    text: str

    @property
    def heading(self) -> str:
        """Number and title."""
        return f"{self.number}. {self.title}"

    @property
    def files(self) -> dict[str, str]:
        """The files that the reader creates: name -> content."""
        return {block.file: block.text for block in self.blocks if block.kind == "code" and block.file}

    @property
    def exercise(self) -> str:
        """The text of its exercise."""
        return self.text.partition("## Exercise\n")[2].strip()

    @property
    def blocks(self) -> list[Block]:
        """Its blocks, in order."""
        return blocks(self.text)


class GuidePage(NamedTuple):
    """A page that explains how to do one thing.

    Attributes:
        name: its name in commands.
        heading: its title.
        text: all of it, in Markdown.
    """

    name: str
    heading: str
    text: str

    @property
    def blocks(self) -> list[Block]:
        """Its blocks, in order."""
        return blocks(self.text)

    def code(self, language: str, heading: str = "") -> list[str]:
        """Return its code blocks in a language; with a heading, only those under it."""
        under = ""
        found = []
        for block in self.blocks:
            under = block.text if block.kind == "heading" else under
            if block.kind == "code" and block.language == language and heading in ("", under):
                found.append(block.text)
        return found


def blocks(text: str) -> list[Block]:
    """Return the blocks of a Markdown text, in order."""
    found: list[Block] = []
    position = 0
    for fence in _CODE.finditer(text):
        found.extend(_prose(text[position : fence.start()]))
        found.append(Block("code", fence["text"], fence["language"], fence["file"] or ""))
        position = fence.end()
    return [*found, *_prose(text[position:])]


def _prose(text: str) -> Iterator[Block]:
    for part in _BREAK.split(_HIDDEN.sub("", text).strip()):
        picture = _PICTURE.fullmatch(part.strip())
        if picture:
            yield Block("picture", picture["text"], file=picture["file"])
            continue
        lines = [line.strip() for line in part.splitlines()]
        if part.startswith("|"):
            rows = [_cells(line) for line in lines if not _RULE.fullmatch(line) or line == lines[0]]
            if any(map(any, rows)):
                yield Block("table", "", rows=tuple(rows))
            continue
        line = " ".join(lines)
        mark = next((mark for mark in _MARKS if line.startswith(mark)), "")
        if line:
            yield Block(_MARKS.get(mark, "paragraph"), line.removeprefix(mark))


def _cells(line: str) -> tuple[str, ...]:
    return tuple(cell.strip().replace("\\|", "|") for cell in _BAR.split(line)[1:-1])


def steps() -> list[GuideStep]:
    """Return all steps, in order."""
    found = []
    for path in sorted(STEPS.glob("*.md")):
        text = path.read_text(encoding="utf-8")
        number, _, name = path.stem.partition("-")
        found.append(GuideStep(int(number), name, text.partition("\n")[0].lstrip("# "), text))
    return found


def pages() -> dict[str, GuidePage]:
    """Return the how-to pages by name."""
    found = {}
    for path in sorted(HOWTO.glob("*.md")):
        text = path.read_text(encoding="utf-8")
        found[path.stem] = GuidePage(path.stem, text.partition("\n")[0].lstrip("# "), text)
    return found


class _Style(NamedTuple):
    """The style of headings and commands in a terminal.

    Attributes:
        colour: whether it supports escape sequences; if not, commands keep their backticks.
    """

    colour: bool

    def strong(self, text: str) -> str:
        """Return a text in bold."""
        return f"{_BOLD}{text}{_RESET}" if self.colour and text else text

    def marked(self, text: str) -> str:
        """Return a text of one or more lines with its commands highlighted."""
        if not self.colour:
            return text
        return _COMMAND.sub(lambda found: "\n".join(map(self.strong, found[1].split("\n"))), text)

    def width(self, text: str) -> int:
        """Return the number of columns of a text once it is highlighted."""
        return len(text) - self.colour * text.count("`")


def for_terminal(page: GuideStep | GuidePage, width: int, colour: bool) -> str:
    """Return a step or page as text for a terminal.

    Args:
        page: the step or page.
        width: width of the terminal in columns.
        colour: whether commands and headings are highlighted with escape sequences.
    """
    style = _Style(colour)
    lines: list[str] = []
    prefix = ""
    for block in page.blocks:
        if block.kind == "picture":
            continue
        if prefix and (prefix, block.kind) != ("item", "item"):
            lines.append("")
        prefix = block.kind
        if block.kind == "title":
            lines.append(style.strong(page.heading))
        elif block.kind == "heading":
            lines.append(style.strong(block.text))
        elif block.kind == "code":
            lines.extend([style.strong(f"    {block.file}:")] * bool(block.file))
            lines.extend(
                "    " + (style.strong(line) if line.startswith("$ ") else line) for line in block.text.splitlines()
            )
        elif block.kind == "table":
            lines.extend(_table(block, width, style))
        else:
            lines.extend(_wrapped(plain(block.text), width, "- " if block.kind == "item" else "", style))
    return "\n".join(lines) + "\n"


def plain(text: str) -> str:
    """Return a line of a block with only the `...` marks of its commands; links include their targets."""

    def shown(found: re.Match[str]) -> str:
        if found["label"] is None:
            return found["word"] or found["link"] or found[0]
        name, label = _PAGE.fullmatch(found["to"]), plain(found["label"])
        to = f"pyros1 guide howto {name[1]}" if name else found["to"]
        return f"{label} ({to})" if name or to.startswith("http") else label

    return _INLINE.sub(shown, text)


def _table(table: Block, width: int, style: _Style) -> Iterator[str]:
    """Yield the rows in columns if they fit, else an item for each row."""
    head, *rows = (tuple(map(plain, row)) for row in table.rows)
    widths = [max(map(style.width, column)) for column in zip(head, *rows, strict=True)]
    if sum(widths) + 2 * (len(widths) - 1) <= width:
        for row in (head, *rows):
            cells = (cell + " " * (wide - style.width(cell)) for cell, wide in zip(row, widths, strict=True))
            line = "  ".join(cells).rstrip()
            if line:
                yield (
                    style.strong(line.replace("`", "") if style.colour else line) if row is head else style.marked(line)
                )
        return
    for first, *other_rows in rows:
        yield from _wrapped(first, width, "- ", style)
        for name, cell in zip(head[1:], other_rows, strict=True):
            if cell:
                yield from _wrapped(f"{name}: {cell}" if name and len(other_rows) > 1 else cell, width, "  ", style)


def _wrapped(text: str, width: int, prefix: str, style: _Style) -> list[str]:
    """Return lines of a width; those after the first are indented by the length of the prefix."""
    filled = textwrap.fill(
        text, width, initial_indent=prefix, subsequent_indent=" " * len(prefix), break_on_hyphens=False
    )
    return style.marked(filled).split("\n")
