"""Which tests `tests/run --changed` runs."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.changed import PAGE, RULES, select


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    for folder in ("tests/node/publishing", "tests/guide", "tests/wire"):
        (tmp_path / folder).mkdir(parents=True)
    for file in ("tests/test_graph.py", "tests/node/test_clock.py", "tests/wire/test_http.py"):
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
        (["src/pyros1/__main__.py", "pyproject.toml", "interop/topics/test_latch_rospy.py"], []),
        (["README.md"], ["tests/guide"]),
        (["src/pyros1/web/page/lib/dom.js"], sorted(PAGE)),
        (["tests/web/page/robot.test.mjs"], sorted(PAGE)),
    ],
)
def test_tests_of_the_rooms_of_a_change(checkout: Path, changed: list[str], tests: list[str]) -> None:
    assert select(changed, checkout) == sorted([RULES, *tests])
