"""The page's vendored libraries are those that their list names; how they are verified and updated."""

from __future__ import annotations

import io
import json
import re
import subprocess
import tarfile
from pathlib import Path
from typing import Any

import pytest
from tests.javascript import vendored

CHECKS = Path(vendored.__file__).parent


def test_vendored_libraries_are_those_of_the_list() -> None:
    assert list(vendored.problems()) == []
    libraries = vendored.read_list()
    assert {library["package"] for library in libraries} == {"@dagrejs/dagre", "three", "uplot"}
    for library in libraries:
        [licence] = [name for name in library["files"] if name.endswith(".LICENSE")]
        assert library["licence"] == "MIT" and "MIT" in (vendored.VENDOR / licence).read_text(encoding="utf-8")


def test_types_are_those_of_the_vendored_versions() -> None:
    installed = json.loads((CHECKS / "package.json").read_text(encoding="utf-8"))["devDependencies"]
    for library in vendored.read_list():
        package = "@types/three" if library["package"] == "three" else library["package"]
        assert installed[package].split(".")[:2] == library["version"].split(".")[:2], package


def test_the_lock_file_names_no_registry() -> None:
    text = (CHECKS / "package-lock.json").read_text(encoding="utf-8")
    assert '"resolved"' not in text, "npm install --omit-lockfile-registry-resolved"
    assert text.count('"integrity": "sha512-') > 50


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A vendor folder with one library of two files."""
    files = {}
    for name, source, content in (("small.LICENSE", "LICENSE", b"MIT"), ("small.js", "dist/small.js", b"old")):
        (tmp_path / name).write_bytes(content)
        files[name] = {"source": source, "sha256": vendored.sha256(content)}
    library = {"package": "@some/small", "version": "1.0.0", "licence": "MIT", "files": files}
    (tmp_path / vendored.LIST).write_text(json.dumps([{**library, "replace": {"from 'big'": "from './big.js'"}}]))
    assert list(vendored.problems(tmp_path)) == []
    return tmp_path


def test_what_is_wrong_with_a_vendored_file_is_reported(folder: Path) -> None:
    (folder / "small.js").write_bytes(b"changed by hand")
    (folder / "small.LICENSE").unlink()
    (folder / "other.js").touch()
    assert list(vendored.problems(folder)) == [
        "small.LICENSE: is missing",
        "small.js: is not the file of @some/small 1.0.0 that versions.json lists",
        "other.js: is not in versions.json",
    ]


def test_a_library_without_a_licence_is_reported(folder: Path) -> None:
    [library] = vendored.read_list(folder)
    del library["files"]["small.LICENSE"]
    (folder / "small.LICENSE").unlink()
    (folder / vendored.LIST).write_text(json.dumps([library]))
    assert list(vendored.problems(folder)) == ["@some/small: no licence is among its files"]


def npm_pack(files: dict[str, str]) -> Any:
    """Return what stands for subprocess.run: an npm that packs these files."""

    def run(command: list[str], **_: Any) -> subprocess.CompletedProcess[bytes]:
        assert command[:2] == ["npm", "pack"] and "@some/small@latest" in command
        with tarfile.open(Path(command[-1]) / "some-small.tgz", "w:gz") as tar:
            for name, text in files.items():
                entry = tarfile.TarInfo(f"package/{name}")
                entry.size = len(text.encode())
                tar.addfile(entry, io.BytesIO(text.encode()))
        return subprocess.CompletedProcess(command, 0)

    return run


def test_an_update_writes_the_files_and_the_list(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Imports are adapted, and a script does not name a source map that is not vendored."""
    text = "import { x } from 'big';\n//# sourceMappingURL=small.js.map\n"
    manifest = json.dumps({"version": "1.2.0", "license": "MIT"})
    packed = {"package.json": manifest, "LICENSE": "MIT", "dist/small.js": text, "dist/more.js": ""}
    monkeypatch.setattr(subprocess, "run", npm_pack(packed))
    assert vendored.update("@some/small", "latest", folder) == "1.2.0"
    assert (folder / "small.js").read_text() == "import { x } from './big.js';\n"
    assert list(vendored.problems(folder)) == []
    assert vendored.read_list(folder)[0]["version"] == "1.2.0"
    with pytest.raises(KeyError):
        vendored.update("other", "latest", folder)


def test_imports_of_vendored_modules_have_their_file() -> None:
    """The page is not built: a bare import such as 'three' would not be found by a browser."""
    for path in vendored.VENDOR.rglob("*.js"):
        text = path.read_text(encoding="utf-8")
        for name in re.findall(r"^(?:import|export|\})[^'\"*\n]*from\s*['\"]([^'\"]+)", text, re.MULTILINE):
            assert (path.parent / name).is_file(), f"{path.name}: {name}"
