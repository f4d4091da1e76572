"""The remembered crawl: it answers as a new one would, whatever has changed."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from pyros1.finding import crawl
from pyros1.finding.crawl import Crawl, all_packages, find_cached, measure_folders
from pyros1.finding.manifest import ManifestError, read_manifest
from pyros1.finding.packages import PackageIndex

DEPTH = 20


def package(folder: Path, name: str = "", text: str = "") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "package.xml").write_text(text or f"<package><name>{name or folder.name}</name></package>")
    return folder


def age(root: Path) -> None:
    """Make everything look old enough to be remembered."""
    for base, folders, files in os.walk(root):
        for name in [*folders, *files, "."]:
            os.utime(Path(base, name), ns=(10**18, 10**18))


@pytest.fixture
def environ(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    root = tmp_path / "src"
    package(root / "one")
    package(root / "group" / "two")
    age(root)
    monkeypatch.setattr(crawl, "search_folders", lambda environ: [(str(root), DEPTH)])
    return {"XDG_CACHE_HOME": str(tmp_path / "cache")}


def names(environ: dict[str, str]) -> list[str]:
    return [found.name for found in all_packages(environ)]


def test_packages_are_found_in_the_order_of_their_names(environ: dict[str, str]) -> None:
    assert names(environ) == ["two", "one"]  # group/two stands before one


def test_a_second_crawl_reads_no_folder(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    first = all_packages(environ)
    monkeypatch.setattr("os.scandir", lambda *_: pytest.fail("read again"))
    assert all_packages(environ) == first
    assert find_cached(environ, "two") == first[0]


@pytest.mark.parametrize("old", [False, True])
def test_changes_are_seen_at_once(environ: dict[str, str], tmp_path: Path, old: bool) -> None:
    """``old``: also those that were made with a clock that hardly moves, right after the last crawl."""
    root = tmp_path / "src"

    def changed() -> list[str]:
        if old:
            for folder in (root, root / "group", root / "later"):
                if folder.is_dir():
                    stamp = folder.stat().st_mtime_ns + 1
                    os.utime(folder, ns=(stamp, stamp))
        found = names(environ)
        for name in found:
            quick = find_cached(environ, name)
            assert quick is None or quick.name == name
        return found

    assert names(environ) == ["two", "one"]
    package(root / "three")
    assert changed() == ["two", "one", "three"]
    package(root / "group" / "deeper" / "four")
    assert changed() == ["four", "two", "one", "three"]
    (root / "group").rename(root / "later")
    assert changed() == ["four", "two", "one", "three"]
    package(root / "three", "renamed_package")
    assert changed() == ["four", "two", "one", "renamed_package"]
    (root / "one" / "CATKIN_IGNORE").touch()
    assert changed() == ["four", "two", "renamed_package"]
    (root / "later" / "two" / "package.xml").unlink()
    assert changed() == ["four", "renamed_package"]
    (root / "later" / "COLCON_IGNORE").touch()
    assert changed() == ["renamed_package"]


def test_what_is_gone_is_not_found_quickly(environ: dict[str, str], tmp_path: Path) -> None:
    names(environ)
    assert find_cached(environ, "one") is not None
    (tmp_path / "src" / "one" / "package.xml").unlink()
    assert find_cached(environ, "one") is None
    assert find_cached(environ, "nothing") is None


def test_what_is_too_young_is_not_remembered(tmp_path: Path) -> None:
    package(tmp_path / "one")
    changed = (tmp_path / "one").stat().st_mtime_ns
    young = Crawl({}, changed + 10**9)
    assert [*young.packages(str(tmp_path), DEPTH)] and not young.trusted_records()
    older = Crawl({}, changed + 10**10)
    assert [*older.packages(str(tmp_path), DEPTH)] and older.trusted_records()


def test_links_are_followed_and_loops_end(tmp_path: Path) -> None:
    package(tmp_path / "elsewhere" / "linked")
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "link").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "src" / "broken").symlink_to(tmp_path / "nowhere")
    for name in ("loop", "another", "third"):
        (tmp_path / "src" / name).symlink_to(tmp_path / "src")
    found = {each.name for each in Crawl({}).packages(str(tmp_path / "src"), DEPTH)}
    assert found == {"linked"}


DAMAGED = ["", "no json", "[]", "[99, {}]", "[1, []]", '[1, {"x": 5}]', "null", "[" * 100_000]


@pytest.mark.parametrize("content", DAMAGED, ids=range(len(DAMAGED)))
def test_a_damaged_record_does_no_harm(environ: dict[str, str], tmp_path: Path, content: str) -> None:
    names(environ)
    for file in (tmp_path / "cache").rglob("*.json"):
        file.write_text(content)
    assert names(environ) == ["two", "one"]


@pytest.mark.parametrize("wrong", [[0, 5, "", 0, "", False], ["0", [], "", 0, "", False], [0, [""], "", 0, "", False]])
def test_records_of_other_values_do_no_harm(environ: dict[str, str], tmp_path: Path, wrong: list[object]) -> None:
    names(environ)
    for file in (tmp_path / "cache").rglob("*.json"):
        version, records = json.loads(file.read_text())
        file.write_text(json.dumps([version, dict.fromkeys(records, wrong)]))
    assert find_cached(environ, "one") is None
    assert names(environ) == ["two", "one"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_a_pipe_in_the_records_place_is_not_waited_for(environ: dict[str, str], tmp_path: Path) -> None:
    names(environ)
    for file in (tmp_path / "cache").rglob("*.json"):
        file.unlink()
        os.mkfifo(file)
    assert names(environ) == ["two", "one"]


def test_where_nothing_can_be_remembered_all_is_read(environ: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("a file in the way")
    assert names(environ) == names(environ) == ["two", "one"]


def test_metapackages_and_names_in_comments(tmp_path: Path) -> None:
    package(tmp_path / "a", text="<package><!-- <name>no</name> <metapackage/> --><name> yes </name></package>")
    package(tmp_path / "b", text="<package><name>meta</name><export><metapackage/></export></package>")
    package(tmp_path / "c", text="nonsense")
    found = [(each.name, each.is_meta) for each in Crawl({}).packages(str(tmp_path), DEPTH)]
    assert found == [("yes", False), ("meta", True), ("c", False)]


def test_names_are_those_of_the_index(environ: dict[str, str], tmp_path: Path) -> None:
    for number, name in enumerate(["<name >plain</name>", "<name>\nlines\n</name\n>", "<name><![CDATA[no]]></name>"]):
        package(tmp_path / "ws" / f"p{number}", text=f"<package>{name}</package>")
    environ["ROS_PACKAGE_PATH"] = str(tmp_path / "ws")
    found = [each.name for each in Crawl({}).packages(str(tmp_path / "ws"), DEPTH)]
    assert found == ["plain", "lines", "p2"]
    assert {*found} <= {*PackageIndex(environ).list()}


def test_profile_names_folders_without_packages(tmp_path: Path) -> None:
    package(tmp_path / "src" / "a")
    (tmp_path / "src" / "empty").mkdir()
    rows = {folder: holds for _, folder, holds in measure_folders([(str(tmp_path / "src"), DEPTH)])}
    assert rows == {str(tmp_path / "src"): True, str(tmp_path / "src" / "empty"): False}


def test_a_manifest_is_a_regular_file(tmp_path: Path) -> None:
    (tmp_path / "package.xml").symlink_to("/dev/null")
    with pytest.raises(ManifestError, match="not a regular file"):
        read_manifest(tmp_path / "package.xml")
