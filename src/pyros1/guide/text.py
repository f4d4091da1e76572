"""The steps of the guide, which are files in Markdown.

In a step's ``console`` blocks a line with ``$`` is a command, and what follows is what it prints; ``...`` stands for
lines that are left out, ``^C`` for the key. A block with a file's name after its language is a file that the reader
makes.
"""

from __future__ import annotations

import re
import textwrap
from pathlib import Path
from typing import NamedTuple

STEPS = Path(__file__).parent / "steps"
_BOLD, _DIM, _RESET = "\x1b[1m", "\x1b[2m", "\x1b[0m"


class GuideStep(NamedTuple):
    """A step of the guide.

    Attributes:
        number: from 1 up.
        title: its heading.
        text: all of it, in Markdown.
    """

    number: int
    title: str
    text: str

    @property
    def files(self) -> dict[str, str]:
        """The files that the reader makes: name -> content."""
        return dict(re.findall(r"^```\w+ (\S+)\n(.*?)^```$", self.text, re.M | re.S))

    @property
    def exercise(self) -> str:
        """The text of its exercise."""
        return self.text.partition("## Exercise\n")[2].strip()


def steps() -> list[GuideStep]:
    """Return all steps, in their order."""
    found = []
    for path in sorted(STEPS.glob("*.md")):
        text = path.read_text(encoding="utf-8")
        found.append(GuideStep(int(path.name.partition("-")[0]), text.partition("\n")[0].lstrip("# "), text))
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
    paragraph: list[str] = []
    inside = False

    def end() -> None:
        if paragraph:
            text = re.sub(r"\*(\w[^*]*)\*", r"\1", " ".join(line.strip() for line in paragraph)).replace("`", "")
            item = "  " if text.startswith("- ") else ""
            lines.extend(textwrap.wrap(text, width, subsequent_indent=item, break_on_hyphens=False))
            paragraph.clear()

    for line in step.text.splitlines():
        if line.startswith("```"):
            end()
            inside = not inside
            name = line.partition(" ")[2]
            if name:
                lines.append(strong(f"    {name}:"))
        elif inside:
            lines.append("    " + (strong(line) if line.startswith("$ ") else line))
        elif line.startswith("#"):
            end()
            title = line.lstrip("# ")
            lines.append(strong(f"{step.number}. {title}" if line.startswith("# ") else title))
        elif not line.strip():
            end()
            lines.append("")
        else:
            if line.startswith("- "):
                end()
            paragraph.append(line)
    end()
    return "\n".join(lines) + "\n"
