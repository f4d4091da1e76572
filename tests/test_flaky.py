"""interop/flaky.txt: the tests that may have a second try."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ENTRIES = [
    line for line in (ROOT / "interop/flaky.txt").read_text().splitlines() if line.strip() and not line.startswith("#")
]


def test_few_entries_that_each_name_a_test_and_a_reason() -> None:
    assert len(ENTRIES) <= 10, "mend the tests instead"
    for entry in ENTRIES:
        name, _, reason = entry.partition("  ")
        path, _, test = name.partition("::")
        function = test.split("[")[0].split("::")[-1]
        assert re.search(rf"def {function}\(", (ROOT / path).read_text()), f"{name} does not exist"
        assert len(reason.split()) >= 5, "say what races, in which program, and how that was seen"


LOG = """\
FAILED interop/nodes/test_a.py::test_known[ours] - AssertionError: late
ERROR interop/nodes/test_a.py::test_known[ours] - a process was left
"""


@pytest.mark.parametrize(
    ("log", "again"),
    [
        (LOG, "python interop/nodes/test_a.py::test_known[ours]"),
        (LOG + "FAILED interop/nodes/test_a.py::test_other - assert False\n", ""),
        (LOG + "FAILED interop/nodes/test_a.py::test_known[theirs] - assert False\n", ""),
        ("ERROR interop/nodes/test_a.py - SyntaxError\n", ""),
        ("", ""),
    ],
)
def test_only_listed_tests_are_run_again(tmp_path: Path, log: str, again: str) -> None:
    result = repeated(tmp_path, log)
    assert (result.stdout.strip(), result.stderr) == (again, "")
    assert result.returncode == (0 if again else 1)


def repeated(tmp_path: Path, log: str) -> subprocess.CompletedProcess[str]:
    """Run the function that chooses which tests to run again."""
    source = (ROOT / "tests/run").read_text()
    start = source.index("repeat_later() {")
    function = source[start : source.index("\n}\n", start) + 3]
    (tmp_path / "interop").mkdir(parents=True)
    (tmp_path / "interop/flaky.txt").write_text("interop/nodes/test_a.py::test_known[ours]  stock logs twice\n")
    (tmp_path / "nodes").write_text(log)
    script = (
        f'{function}logs=.; once_more=(); repeat_later nodes python; code=$?; echo "${{once_more[*]-}}"; exit $code'
    )
    return subprocess.run(["bash", "-uc", script], cwd=tmp_path, capture_output=True, text=True, check=False)
