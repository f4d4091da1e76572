"""The links of the documentation to other files of the project."""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import unquote

import pytest

ROOT = Path(__file__).resolve().parents[1]
_LINK = re.compile(r"!?\[[^\]]*\]\(<?([^()\s>]+)>?\)")
_CODE = re.compile(r"^```.*?^```|`[^`\n]*`", re.DOTALL | re.MULTILINE)


def pages() -> list[str]:
    found = [*ROOT.glob("*.md")]
    for folder in (".github", "interop", "launch", "src", "tests"):
        found += (path for path in (ROOT / folder).rglob("*.md") if "node_modules" not in path.parts)
    return sorted(path.relative_to(ROOT).as_posix() for path in found)


@pytest.mark.parametrize("page", pages())
def test_links_lead_to_files(page: str) -> None:
    text = _CODE.sub("", (ROOT / page).read_text(encoding="utf-8"))
    targets = {unquote(target.partition("#")[0]) for target in _LINK.findall(text) if ":" not in target}
    assert not [target for target in targets if target and not (ROOT / page).parent.joinpath(target).exists()]
