"""Which tests `tests/run --changed` runs."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.changed import COMMON, PAGE, PUBLIC, ROOT, RULES, select


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    for folder in ("tests/node/publishing", "tests/guide", "tests/wire"):
        (tmp_path / folder).mkdir(parents=True)
    for file in (
        *PUBLIC,
        "tests/test_graph.py",
        "tests/test_turn.py",
        "tests/node/test_clock.py",
        "tests/wire/test_http.py",
    ):
        (tmp_path / file).touch()
    return tmp_path


@pytest.mark.parametrize(
    ("changed", "tests"),
    [
        ([], []),
        (["src/pyros1/node/publishing/tcp_link.py"], ["tests/node/publishing"]),
        (["src/pyros1/node/services/provider_connection.py"], ["tests/node"]),  # a folder without tests of its own
        (["src/pyros1/wire/http.py", "src/pyros1/node/clock.py"], ["tests/node", "tests/wire"]),
        (["src/pyros1/node/clock.py", "src/pyros1/node/publishing/tcp_link.py"], ["tests/node"]),
        (["tests/node/test_clock.py"], ["tests/node/test_clock.py"]),
        (["tests/node/test_gone.py"], []),
        (["tests/node/test_clock.py", "tests/node/parts.py"], ["tests/node"]),
        (["src/pyros1/graph.py"], ["tests/test_graph.py"]),
        (["src/pyros1/__main__.py", "interop/topics/test_latch_rospy.py"], []),
        (["tests/turn.py"], ["tests/test_turn.py"]),
        (["tests/coverage_floor.py", "LICENSE"], []),
        (["README.md"], ["tests/guide"]),
        (["src/pyros1/web/page/lib/dom.js"], sorted(PAGE)),
        (["tests/web/page/robot.test.mjs"], sorted(PAGE)),
        ([".github/workflows/tests.yml"], ["tests/javascript"]),
    ],
)
def test_tests_of_the_rooms_of_a_change(checkout: Path, changed: list[str], tests: list[str]) -> None:
    public = PUBLIC if any(name.startswith("src/") and name.endswith(".py") for name in changed) else ()
    assert select(changed, checkout) == sorted([RULES, *public, *tests])


@pytest.mark.parametrize("changed", ["pyproject.toml", "tests/conftest.py", "src/pyros1/__init__.py"])
def test_what_all_tests_depend_on(checkout: Path, changed: str) -> None:
    assert select(["src/pyros1/node/clock.py", changed], checkout) == ["tests"]


def test_files_that_count_for_all_tests_exist() -> None:
    assert all((ROOT / name).exists() for name in (*COMMON, *PUBLIC, *PAGE))
