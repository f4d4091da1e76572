"""Reads the guide's steps and how-to pages, which are Markdown files, and formats them for a terminal.

In a step's ``console`` blocks, a line that starts with ``$`` is a command, followed by its output; ``...`` stands for
omitted lines, and ``^C`` for the key. A block with a file name after its language is a file that the reader creates.
Pages also have tables and links. Images whose files belong to the web page, each in its own paragraph, are also
displayed in the browser; other images can only be seen when the Markdown files are read in the repository.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

STEPS_FOLDER = Path(__file__).parent / "steps"
HOWTO_FOLDER = Path(__file__).parent / "howto"
_BOLD, _RESET = "\x1b[1m", "\x1b[0m"
_CODE_BLOCK = re.compile(r"(?ms)^```(?P<language>\w+)(?: (?P<file>\S+))?\n(?P<text>.*?)^```$")
_HIDDEN_MARKUP = re.compile(r"(?m)^<!--.*-->\n|!\[[^\]]*\]\((?![./]+/web/page/)[^)]*\)")
_PICTURE = re.compile(r"!\[(?P<text>[^\]]+)\]\([./]+/web/page/(?P<file>pictures/[\w.]+)\)")
_PARAGRAPH_BREAK = re.compile(r"\n\s*\n|\n(?=- )")
_TABLE_SEPARATOR = re.compile(r"[|:\s-]+")
_CELL_SEPARATOR = re.compile(r"(?<!\\)\|")
_KINDS_BY_PREFIX = {"# ": "title", "## ": "heading", "- ": "item"}
_INLINE_MARKUP = re.compile(
    r"`(?P<code>[^`]+)`|\*(?P<word>\w[^*]*)\*|\[(?P<label>[^\]]+)\]\((?P<to>[^)]+)\)|<(?P<link>http[^>]+)>"
)
_COMMAND = re.compile(r"`([^`]+)`")
_PAGE_FILE = re.compile(r"(\w+)\.md")


class Block(NamedTuple):
    """Part of a step or page, such as a paragraph.

    Attributes:
        kind: "title", "heading", "paragraph", "item" (of a list), "table", "picture" or "code".
        text: for code, the lines as typed or printed; for a table, empty; otherwise one line, with markup for `code`,
            *words* and [links](x.md).
        language: the code's language, such as "console", "python", "xml" or "text".
        file: the name of the file that the reader creates from the code, or a picture's path; otherwise empty.
        rows: a table's cells, by row. The first row is the header, whose cells may be empty.
    """

    kind: str
    text: str
    language: str = ""
    file: str = ""
    rows: tuple[tuple[str, ...], ...] = ()


class GuideStep(NamedTuple):
    """A step of the guide.

    Attributes:
        number: the step's number, starting at 1.
        name: the step's name, which does not change if the number does.
        title: the step's title.
        text: the whole step in Markdown.
    """

    number: int
    name: str
    title: str
    text: str

    @property
    def heading(self) -> str:
        """The step's number and title."""
        return f"{self.number}. {self.title}"

    @property
    def files(self) -> dict[str, str]:
        """The files that the reader creates in this step: name -> content."""
        return {block.file: block.text for block in self.blocks if block.kind == "code" and block.file}

    @property
    def exercise(self) -> str:
        """The text of the step's exercise."""
        return self.text.partition("## Exercise\n")[2].strip()

    @property
    def blocks(self) -> list[Block]:
        """The blocks in order."""
        return parse_blocks(self.text)


class GuidePage(NamedTuple):
    """A how-to page, which explains how to do one task.

    Attributes:
        name: the page's name in commands.
        heading: the page's title.
        text: the whole page in Markdown.
    """

    name: str
    heading: str
    text: str

    @property
    def blocks(self) -> list[Block]:
        """The blocks in order."""
        return parse_blocks(self.text)

    def code(self, language: str, heading: str = "") -> list[str]:
        """Return the page's code in a language: the text of each block, or only of the blocks under a given heading."""
        current_heading = ""
        code_blocks = []
        for block in self.blocks:
            current_heading = block.text if block.kind == "heading" else current_heading
            if block.kind == "code" and block.language == language and heading in ("", current_heading):
                code_blocks.append(block.text)
        return code_blocks


def parse_blocks(text: str) -> list[Block]:
    """Return the blocks of a Markdown document in order."""
    parsed_blocks: list[Block] = []
    position = 0
    for code_match in _CODE_BLOCK.finditer(text):
        parsed_blocks.extend(_parse_prose(text[position : code_match.start()]))
        parsed_blocks.append(Block("code", code_match["text"], code_match["language"], code_match["file"] or ""))
        position = code_match.end()
    return [*parsed_blocks, *_parse_prose(text[position:])]


def _parse_prose(text: str) -> Iterator[Block]:
    for part in _PARAGRAPH_BREAK.split(_HIDDEN_MARKUP.sub("", text).strip()):
        picture_match = _PICTURE.fullmatch(part.strip())
        if picture_match:
            yield Block("picture", picture_match["text"], file=picture_match["file"])
            continue
        lines = [line.strip() for line in part.splitlines()]
        if part.startswith("|"):
            rows = [_split_cells(line) for line in lines if not _TABLE_SEPARATOR.fullmatch(line) or line == lines[0]]
            if any(map(any, rows)):
                yield Block("table", "", rows=tuple(rows))
            continue
        line = " ".join(lines)
        prefix = next((prefix for prefix in _KINDS_BY_PREFIX if line.startswith(prefix)), "")
        if line:
            yield Block(_KINDS_BY_PREFIX.get(prefix, "paragraph"), line.removeprefix(prefix))


def _split_cells(line: str) -> tuple[str, ...]:
    return tuple(cell.strip().replace("\\|", "|") for cell in _CELL_SEPARATOR.split(line)[1:-1])


def steps() -> list[GuideStep]:
    """Read all steps of the guide, in order."""
    all_steps = []
    for path in sorted(STEPS_FOLDER.glob("*.md")):
        text = path.read_text(encoding="utf-8")
        number, _, name = path.stem.partition("-")
        all_steps.append(GuideStep(int(number), name, text.partition("\n")[0].lstrip("# "), text))
    return all_steps


def pages() -> dict[str, GuidePage]:
    """Read all how-to pages: name -> page."""
    pages_by_name = {}
    for path in sorted(HOWTO_FOLDER.glob("*.md")):
        text = path.read_text(encoding="utf-8")
        pages_by_name[path.stem] = GuidePage(path.stem, text.partition("\n")[0].lstrip("# "), text)
    return pages_by_name


class _Style(NamedTuple):
    """The highlighting of headings and commands in a terminal.

    Attributes:
        colour: whether the terminal supports escape sequences; if not, commands keep their backticks.
    """

    colour: bool

    def bold(self, text: str) -> str:
        """Return a string in bold."""
        return f"{_BOLD}{text}{_RESET}" if self.colour and text else text

    def highlight_commands(self, text: str) -> str:
        """Return a string, of one or more lines, with its commands highlighted."""
        if not self.colour:
            return text
        return _COMMAND.sub(lambda match: "\n".join(map(self.bold, match[1].split("\n"))), text)

    def width(self, text: str) -> int:
        """Return the number of columns that a string takes up once its commands are highlighted."""
        return len(text) - self.colour * text.count("`")


def format_for_terminal(page: GuideStep | GuidePage, width: int, colour: bool) -> str:
    """Return a step or page as text for a terminal.

    Args:
        page: the step or page.
        width: the width of the terminal in columns.
        colour: whether to highlight commands and headings with escape sequences.
    """
    style = _Style(colour)
    lines: list[str] = []
    previous_kind = ""
    for block in page.blocks:
        if block.kind == "picture":
            continue
        if previous_kind and (previous_kind, block.kind) != ("item", "item"):
            lines.append("")
        previous_kind = block.kind
        if block.kind == "title":
            lines.append(style.bold(page.heading))
        elif block.kind == "heading":
            lines.append(style.bold(block.text))
        elif block.kind == "code":
            lines.extend([style.bold(f"    {block.file}:")] * bool(block.file))
            lines.extend(
                "    " + (style.bold(line) if line.startswith("$ ") else line) for line in block.text.splitlines()
            )
        elif block.kind == "table":
            lines.extend(_format_table(block, width, style))
        else:
            lines.extend(_wrap(remove_markup(block.text), width, "- " if block.kind == "item" else "", style))
    return "\n".join(lines) + "\n"


def remove_markup(text: str) -> str:
    """Return a string without its markup, except the backticks around commands. Links are followed by their targets."""

    def replacement(match: re.Match[str]) -> str:
        if match["label"] is None:
            return match["word"] or match["link"] or match[0]
        page_match, label = _PAGE_FILE.fullmatch(match["to"]), remove_markup(match["label"])
        target = f"pyros1 guide howto {page_match[1]}" if page_match else match["to"]
        return f"{label} ({target})" if page_match or target.startswith("http") else label

    return _INLINE_MARKUP.sub(replacement, text)


def _format_table(table: Block, width: int, style: _Style) -> Iterator[str]:
    """Yield a table's lines: in columns if they fit, otherwise as a list with an item for each row."""
    header, *rows = (tuple(map(remove_markup, row)) for row in table.rows)
    widths = [max(map(style.width, column)) for column in zip(header, *rows, strict=True)]
    if sum(widths) + 2 * (len(widths) - 1) <= width:
        for row in (header, *rows):
            cells = (
                cell + " " * (column_width - style.width(cell)) for cell, column_width in zip(row, widths, strict=True)
            )
            line = "  ".join(cells).rstrip()
            if line:
                yield (
                    style.bold(line.replace("`", "") if style.colour else line)
                    if row is header
                    else style.highlight_commands(line)
                )
        return
    for first_cell, *other_cells in rows:
        yield from _wrap(first_cell, width, "- ", style)
        for name, cell in zip(header[1:], other_cells, strict=True):
            if cell:
                yield from _wrap(f"{name}: {cell}" if name and len(other_cells) > 1 else cell, width, "  ", style)


def _wrap(text: str, width: int, prefix: str, style: _Style) -> list[str]:
    """Wrap text to a width; return its lines. All lines after the first are indented by the length of the prefix."""
    filled = textwrap.fill(
        text, width, initial_indent=prefix, subsequent_indent=" " * len(prefix), break_on_hyphens=False
    )
    return style.highlight_commands(filled).split("\n")
