"""Modules of the page that need no browser: Node.js runs their tests, which are beside this file; hints of the page."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

import pyros1

ROOM = Path(pyros1.__file__).parent
TESTS = sorted(Path(__file__).with_name("page").glob("*.test.mjs"))


@pytest.mark.slow
@pytest.mark.once
@pytest.mark.skipif(shutil.which("node") is None, reason="needs Node.js")
@pytest.mark.parametrize("file", TESTS, ids=lambda file: file.name.partition(".")[0])
def test_modules_of_the_page(file: Path) -> None:
    done = subprocess.run(["node", "--test", str(file)], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_programs_and_launch_files_of_hints_are_there() -> None:
    texts = [file.read_text(encoding="utf-8") for file in (ROOM / "web" / "page").rglob("*.js")]
    hints = {hint for text in texts for hint in re.findall(r"pyros1 (run|launch) (\w+) ([\w.]+)", text)}
    assert len(hints) > 5
    for verb, package, name in hints:
        assert (ROOM / "packages" / package / {"run": "scripts", "launch": "launch"}[verb] / name).is_file()


def test_texts_can_be_read_by_day_and_at_night() -> None:
    """Contrasts as https://www.w3.org/TR/WCAG21/#contrast-minimum wants them; white words stood on light orange."""
    style = (ROOM / "web" / "page" / "style.css").read_text(encoding="utf-8")
    light = colours(re.search(r":root \{(.*?)\}", style, re.DOTALL)[1])  # type: ignore[index]
    nights = re.findall(r':root(?:\[data-theme="dark"\]|:not\(\[data-theme="light"\]\)) \{(.*?)\}', style, re.DOTALL)
    first, second = map(colours, nights)
    assert first == second and first.keys() == light.keys()
    pairs = [("on-accent", "accent"), ("accent", "accent-soft"), ("text", "surface"), ("text", "raised")]
    pairs += [
        (name, "surface") for name in ("muted", "accent", "ok", "warn", "error", "fatal", "info", "debug", "node")
    ]
    for theme in (light, first):
        for text, under in pairs:
            assert contrast(theme[text], theme[under]) >= 4.5, (text, theme[text], under, theme[under])


def colours(block: str) -> dict[str, str]:
    return dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6})", block))


def contrast(one: str, other: str) -> float:
    lighter, darker = sorted((brightness(one), brightness(other)), reverse=True)
    return (lighter + 0.05) / (darker + 0.05)


def brightness(colour: str) -> float:
    parts = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
    red, green, blue = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue
