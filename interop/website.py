"""Makes the site that GitHub shows, of guide, how-to pages and reference: ``python interop/website.py [FOLDER]``.

It needs the extra ``docs``. FOLDER is ``dist/site`` if it is not given. Links to files of the repository lead to it if
the environment says where it is, as on GitHub (GITHUB_SERVER_URL, GITHUB_REPOSITORY).
"""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Sequence
from html import escape
from pathlib import Path

import reference

from pyros1.guide.documents import HOWTO_FOLDER, STEPS_FOLDER, Block, GuidePage, GuideStep, pages, steps
from pyros1.web.server.assets import PAGE_FOLDER

ROOT = Path(__file__).resolve().parents[1]
INLINE = re.compile(r"`([^`]+)`|\*(\w[^*]*)\*|\[([^\]]+)\]\(([^)]+)\)|<(http[^>]+)>")
TAGS = {"title": "h1", "heading": "h2", "paragraph": "p", "item": "li"}
STYLE = """
body { max-width: 48rem; margin: 2rem auto; padding: 0 1rem; font: 1rem/1.5 system-ui, sans-serif; }
pre { overflow-x: auto; padding: .7rem; border: 1px solid #8884; border-radius: 6px; }
code, pre { font-family: ui-monospace, monospace; font-size: .88em; }
figure { margin: 1rem 0; } figcaption { opacity: .7; } img { max-width: 100%; height: auto; }
table { border-collapse: collapse; } td, th { border: 1px solid #8884; padding: .3rem .6rem; text-align: left; }
:root { color-scheme: light dark; }
"""


def repository() -> str:
    """Return the address of the repository's files; empty if nobody says it."""
    name = os.environ.get("GITHUB_REPOSITORY")
    return f"{os.environ.get('GITHUB_SERVER_URL', 'https://github.com')}/{name}/blob/main" if name else ""


def link(to: str, folder: Path) -> str:
    """Return where a link of a page leads on the site; empty: nowhere.

    Args:
        to: the link as the page has it.
        folder: that of the page.
    """
    if to.startswith("http"):
        return to
    path = Path(os.path.normpath(folder / to))
    if path.suffix == ".md" and path.parent in (HOWTO_FOLDER, STEPS_FOLDER):
        return f"../{path.parent.name}/{path.stem}.html"
    return f"{repository()}/{path.relative_to(ROOT).as_posix()}" if repository() else ""


def inline(text: str, folder: Path) -> str:
    """Return a line of text as HTML."""
    made = []
    position = 0
    for found in INLINE.finditer(text):
        made.append(escape(text[position : found.start()]))
        position = found.end()
        code, word, label, to, address = found.groups()
        if code:
            made.append(f"<code>{escape(code)}</code>")
        elif word:
            made.append(f"<em>{escape(word)}</em>")
        else:
            where = link(to or address, folder)
            shown = inline(label, folder) if label else escape(address)
            made.append(f'<a href="{escape(where)}">{shown}</a>' if where else shown)
    return "".join([*made, escape(text[position:])])


def element(block: Block, folder: Path) -> str:
    """Return a part of a page as HTML."""
    if block.kind == "code":
        name = f"<figcaption>{escape(block.file)}</figcaption>" if block.file else ""
        return f"<figure>{name}<pre>{escape(block.text)}</pre></figure>"
    if block.kind == "picture":
        text = escape(block.text)
        return f'<figure><img src="../{block.file}" alt="{text}"><figcaption>{text}</figcaption></figure>'
    if block.kind == "table":
        rows = (f"<td>{'</td><td>'.join(inline(cell, folder) for cell in row)}</td>" for row in block.rows)
        return f"<table><tr>{'</tr><tr>'.join(rows)}</tr></table>"
    tag = TAGS[block.kind]
    return f"<{tag}>{inline(block.text, folder)}</{tag}>"


def document(title: str, body: str, above: str = "../") -> str:
    """Return a page of the site."""
    head = f'<meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>{escape(title)}</title>'
    home = f'<p><a href="{above}index.html">pyros1</a></p>' if above else ""
    head += f"<style>{STYLE}</style>"
    return f"<!DOCTYPE html>\n<html lang=en><head>{head}</head>\n<body>{home}{body}</body></html>\n"


def write(found: Sequence[tuple[str, GuideStep | GuidePage]], folder: Path, target: Path) -> str:
    """Write pages, each with a link to the next. Return a list of links to them.

    Args:
        found: the names of the pages' files, and the pages.
        folder: where their Markdown is.
        target: of the site.
    """
    place = target / folder.name
    place.mkdir(parents=True, exist_ok=True)
    for (name, page), after in zip(found, [*found[1:], None], strict=True):
        body = "\n".join(element(block, folder) for block in page.blocks)
        body = re.sub(r"(?s)<li>.*?</li>(?!\n<li>)", r"<ul>\g<0></ul>", body)
        if after:
            body += f'\n<p><a href="{after[0]}.html">Next: {escape(after[1].heading)}</a></p>'
        (place / f"{name}.html").write_text(document(page.heading, body), encoding="utf-8")
    items = (f'<li><a href="{folder.name}/{name}.html">{escape(page.heading)}</a></li>' for name, page in found)
    return f"<ul>{''.join(items)}</ul>"


def make(target: Path) -> None:
    """Write the site into a folder."""
    guide = [(f"{step.number:02}-{step.name}", step) for step in steps()]
    body = "<h1>pyros1</h1><p>ROS 1 as a Python package.</p><h2>The guide</h2>" + write(guide, STEPS_FOLDER, target)
    body += "<h2>How to</h2>" + write(list(pages().items()), HOWTO_FOLDER, target)
    body += '<h2>Reference</h2><p><a href="reference/pyros1.html">All public classes and functions</a></p>'
    (target / "index.html").write_text(document("pyros1", body, above=""), encoding="utf-8")
    shutil.copytree(PAGE_FOLDER / "pictures", target / "pictures", dirs_exist_ok=True)
    reference.make(target / "reference")


if __name__ == "__main__":
    reference.run(make, "dist/site", "index.html")
