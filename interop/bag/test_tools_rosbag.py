"""Stock rosbag and `pyros1 bag` on the same files: what they say, what they make of them; no master is needed.

Besides the bags that stock makes here, those in the folder that ``PYROS1_BAGS`` names are compared.

Feature: bags: info equals stock's, byte for byte -- also for damaged and old files
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness import SOURCE, stock_tools

MAKER = Path(__file__).resolve().parents[1] / "peers" / "stock_bags.py"
STOCK_PYTHON = "/usr/bin/python3"
GOOD = ["plain", "bz2", "lz4", "long", "single", "mixed"]
BAD = ["empty", "cut", "noindex", "zero", "foreign", "nothing"]

pytestmark = pytest.mark.ours_only


def others() -> list[Path]:
    """Bags from elsewhere."""
    folder = os.environ.get("PYROS1_BAGS")
    return sorted(Path(folder).glob("*.bag*")) if folder else []


def call(words: list[object], folder: Path, **environ: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(word) for word in words],
        capture_output=True,
        text=True,
        cwd=folder,
        timeout=60,
        check=False,
        stdin=subprocess.DEVNULL,
        env={**os.environ, "TZ": "Europe/Rome", **environ},
    )


def stock(folder: Path, *words: object) -> subprocess.CompletedProcess[str]:
    code, out, err = stock_tools().ask(
        ["rosbag", *map(str, words)], {**os.environ, "TZ": "Europe/Rome"}, cwd=folder, timeout=60
    )
    return subprocess.CompletedProcess(words, code, out, err)


def ours(folder: Path, *words: object) -> subprocess.CompletedProcess[str]:
    return call([sys.executable, "-m", "pyros1", "bag", *words], folder, PYTHONPATH=str(SOURCE))


def dump(folder: Path, path: object) -> list[str]:
    """All messages of a bag with their connection headers, as stock reads them, sorted."""
    code, out, err = stock_tools().ask([str(MAKER), "dump", str(path)], os.environ, cwd=folder, timeout=60)
    assert code == 0, err
    return sorted(out.splitlines())


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bags")
    result = call([STOCK_PYTHON, MAKER, folder], folder)
    assert result.returncode == 0, result.stderr
    return folder


@pytest.fixture
def bags(made: Path, tmp_path: Path) -> Iterator[Path]:
    """A folder with a copy of the bags that stock made."""
    for path in made.iterdir():
        shutil.copy(path, tmp_path)
    yield tmp_path


OPTIONS = [
    [],
    ["--freq"],
    ["-y"],
    ["-y", "--freq"],
    *(["-y", "-k", key] for key in ("topics", "duration", "start", "types[0].md5")),
]


@pytest.mark.parametrize("options", OPTIONS, ids=" ".join)
def test_info_is_stocks_byte_for_byte_l114(made: Path, options: list[str]) -> None:
    words = ["info", *options, *(f"{name}.bag" for name in GOOD)]
    theirs, mine = stock(made, *words), ours(made, *words)
    assert mine.stdout == theirs.stdout
    assert (mine.returncode, mine.stderr) == (theirs.returncode, "")


@pytest.mark.parametrize("name", BAD)
def test_info_of_what_cannot_be_read_l114(made: Path, name: str) -> None:
    theirs, mine = stock(made, "info", f"{name}.bag"), ours(made, "info", f"{name}.bag")
    assert (mine.stdout, mine.returncode) == (theirs.stdout, theirs.returncode)
    assert bool(mine.stderr) == bool(theirs.stderr)


def test_info_of_several(made: Path) -> None:
    words = ["info", "plain.bag", "bz2.bag", "zero.bag", "lz4.bag"]
    assert ours(made, *words).stdout == stock(made, *words).stdout


@pytest.mark.parametrize("verb", [["compress"], ["compress", "--lz4"], ["decompress"]], ids=" ".join)
@pytest.mark.parametrize("name", GOOD)
def test_stock_reads_what_we_write_l142(bags: Path, name: str, verb: list[str]) -> None:
    before = dump(bags, f"{name}.bag")
    assert ours(bags, *verb, f"{name}.bag").returncode == 0
    assert dump(bags, f"{name}.bag") == before
    assert stock(bags, "info", "--freq", f"{name}.bag").stdout == ours(bags, "info", "--freq", f"{name}.bag").stdout
    assert "does not need any migrations" in stock(bags, "check", f"{name}.bag").stdout
    assert (bags / f"{name}.orig.bag").exists()


def test_stock_compresses_what_we_wrote(bags: Path) -> None:
    before = dump(bags, "long.bag")
    ours(bags, "compress", "long.bag")
    stock(bags, "decompress", "-f", "-q", "long.bag")
    assert dump(bags, "long.bag") == before


@pytest.mark.parametrize("name", ["plain", "lz4", "mixed", "noindex", "cut"])
def test_reindex_saves_what_stock_saves_l143(bags: Path, name: str) -> None:
    shutil.copy(bags / f"{name}.bag", bags / "theirs.bag")
    assert stock(bags, "reindex", "-q", "theirs.bag").returncode == 0
    assert ours(bags, "reindex", "-q", f"{name}.bag").returncode == 0
    saved, theirs = dump(bags, f"{name}.bag"), dump(bags, "theirs.bag")
    assert set(saved) >= set(theirs)
    if name in ("plain", "lz4", "mixed", "cut"):
        assert saved == theirs or name == "cut"
    if name == "noindex":
        assert saved == dump(bags, "plain.bag")


def test_stock_reindexes_what_we_wrote(bags: Path) -> None:
    """It rewrites the bag header in place, which must have the size that it expects."""
    before = dump(bags, "long.bag")
    ours(bags, "decompress", "-q", "long.bag")
    assert stock(bags, "reindex", "-f", "-q", "long.bag").returncode == 0
    assert dump(bags, "long.bag") == before


def test_stock_appends_to_what_we_wrote(bags: Path) -> None:
    before = dump(bags, "plain.bag")
    ours(bags, "decompress", "-q", "plain.bag")
    script = (
        "import rosbag, rospy; from std_msgs.msg import String\n"
        "with rosbag.Bag('plain.bag', 'a') as bag: bag.write('/late', String('x'), rospy.Time(2000))"
    )
    assert call([STOCK_PYTHON, "-c", script], bags).returncode == 0
    after = dump(bags, "plain.bag")
    assert len(after) == len(before) + 1
    assert set(before) < set(after)


@pytest.mark.parametrize(
    "expression",
    [
        "topic == '/number' and m.data % 7 == 0",
        "t.secs == 1002",
        "topic == '/chatter' and m.data.endswith('3')",
        "topic == 'tf' and m.header.stamp.to_sec() > 1003.5",
        "False",
    ],
)
def test_filter_l141(bags: Path, expression: str) -> None:
    assert stock(bags, "filter", "lz4.bag", "theirs.bag", expression).returncode == 0
    assert ours(bags, "filter", "lz4.bag", "mine.bag", expression).returncode == 0
    assert dump(bags, "mine.bag") == dump(bags, "theirs.bag")


@pytest.mark.parametrize(
    "words",
    [
        [],
        ["lz4.bag"],
        ["nope.bag", "x.bag", "True"],
        ["lz4.bag", "lz4.bag", "True"],
        ["noindex.bag", "x.bag", "True"],
    ],
    ids=" ".join,
)
def test_filter_exit_codes(bags: Path, words: list[str]) -> None:
    assert ours(bags, "filter", *words).returncode == stock(bags, "filter", *words).returncode


MAKE_OLD = """
import rosbag, rospy
from std_msgs.msg import Int32, String
with rosbag.Bag("old.bag", "w") as bag:
    header = {"type": "std_msgs/Int32", "md5sum": "55daaea9ec64e37c8a6144d42a7265e2",
              "message_definition": "int16 value", "topic": "/x"}
    for i in range(5):
        bag.write("/x", ("std_msgs/Int32", bytes([i, 0]), header["md5sum"], Int32), rospy.Time(i + 1),
                  raw=True, connection_header=header)
        bag.write("/y", String("same"), rospy.Time(i + 1))
"""


def test_check_and_fix_with_each_others_rules_l139_l140(tmp_path: Path) -> None:
    assert call([STOCK_PYTHON, "-c", MAKE_OLD], tmp_path).returncode == 0
    assert ours(tmp_path, "check", "old.bag").stdout == stock(tmp_path, "check", "old.bag").stdout
    mine, theirs = ours(tmp_path, "fix", "old.bag", "new.bag"), stock(tmp_path, "fix", "old.bag", "new.bag")
    assert (mine.stdout.replace("pyros1 bag", "rosbag"), mine.returncode) == (theirs.stdout, theirs.returncode)
    for maker, user, name in ((ours, stock, "a"), (stock, ours, "b")):
        rules = tmp_path / f"{name}.bmr"
        assert maker(tmp_path, "check", "old.bag", "-g", rules.name).returncode == 0
        text = rules.read_text().replace("valid = False", "valid = True")
        text = text.replace("new_msg.data = 0", "new_msg.data = old_msg.value")
        rules.write_text(
            text.replace("# the old message has no int32 data: new_msg.data = ...", "new_msg.data = old_msg.value")
        )
        fixed = user(tmp_path, "fix", "old.bag", f"{name}.bag", rules.name)
        assert (fixed.stdout, fixed.returncode) == ("Bag migrated successfully.\n", 0)
    assert dump(tmp_path, "a.bag") == dump(tmp_path, "b.bag")
    assert "does not need" in ours(tmp_path, "check", "b.bag").stdout


if others():  # only where there are some: a test without cases counts as left out

    @pytest.mark.parametrize("options", [[], ["--freq"], ["-y", "--freq"]], ids=" ".join)
    @pytest.mark.parametrize("path", others(), ids=lambda path: path.name)
    def test_info_of_bags_from_elsewhere(path: Path, options: list[str]) -> None:
        theirs, mine = stock(path.parent, "info", *options, path), ours(path.parent, "info", *options, path)
        assert (mine.stdout, mine.returncode) == (theirs.stdout, theirs.returncode)

    @pytest.mark.parametrize("path", others(), ids=lambda path: path.name)
    def test_compressing_bags_from_elsewhere_keeps_all(path: Path, tmp_path: Path) -> None:
        if stock(tmp_path, "info", path).returncode:
            pytest.skip("stock cannot read it")
        assert ours(tmp_path, "compress", "--lz4", "--output-dir", ".", path).returncode == 0
        assert dump(tmp_path, path.name) == dump(tmp_path, path)
