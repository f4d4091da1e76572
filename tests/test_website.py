"""The site that GitHub shows: it is made, and all links within it lead somewhere."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from html import unescape
from pathlib import Path

import pytest
import yaml

from pyros1.guide.documents import pages, steps

ROOT = Path(__file__).resolve().parents[1]

pytestmark = pytest.mark.once


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the site, as GitHub makes it."""
    pytest.importorskip("pdoc", reason="the extra docs is not installed")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, str(ROOT / "interop" / "website.py"), str(folder)]
    environ = {**os.environ, "GITHUB_REPOSITORY": "someone/pyros1", "GITHUB_SERVER_URL": "https://github.com"}
    done = subprocess.run(command, env=environ, capture_output=True, text=True, timeout=200, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return folder


def links(file: Path) -> Iterator[str]:
    """Where the links and pictures of a page lead."""
    yield from map(unescape, re.findall(r'(?:href|src)="([^"]+)"', file.read_text(encoding="utf-8")))


@pytest.mark.slow
def test_links_lead_somewhere(site: Path) -> None:
    """Feature: a website with the guide, the how-to pages and the reference -- `python interop/website.py`; a
    workflow publishes it on GitHub
    """
    files = [file for file in site.rglob("*.html") if "reference" not in file.parts]
    assert len(files) == 1 + len(steps()) + len(pages())
    for file in files:
        for to in links(file):
            if to.startswith("https://github.com/someone/pyros1/blob/main/"):
                assert (ROOT / to.partition("/main/")[2]).exists(), f"{file}: {to}"
            elif not to.startswith("http"):
                assert (file.parent / to).is_file(), f"{file}: {to}"
    reached = {(site / to).resolve() for to in links(site / "index.html") if not to.startswith("http")}
    assert {file.resolve() for file in files} - {(site / "index.html").resolve()} <= reached


def test_pages_have_the_text_of_the_guide(site: Path) -> None:
    text = (site / "steps" / "03-look.html").read_text(encoding="utf-8")
    assert "<h1>Inspect a running system</h1>" in text and '<img src="../pictures/graph.webp"' in text
    assert "$ pyros1 topic list\n/rosout" in text and "<code>minimal_nodes</code>" in text
    for file in [*(site / "steps").iterdir(), *(site / "howto").iterdir()]:
        shown = re.sub(r"(?s)<pre>.*?</pre>|<code>.*?</code>", "", file.read_text(encoding="utf-8"))
        assert "](" not in shown and "`" not in shown, file


def test_the_workflow_makes_it() -> None:
    flow = yaml.safe_load((ROOT / ".github" / "workflows" / "pages.yml").read_text(encoding="utf-8"))
    build, deploy = flow["jobs"]["build"], flow["jobs"]["deploy"]
    assert {"run": "python interop/website.py dist/site"} in build["steps"]
    assert {"uses": "actions/upload-pages-artifact@v3", "with": {"path": "dist/site"}} in build["steps"]
    assert deploy["needs"] == "build" and deploy["permissions"] == {"pages": "write", "id-token": "write"}
