"""Verify or update the libraries in the page's ``vendor`` folder, which ``vendor/versions.json`` lists.

::

    python tests/javascript/vendored.py                        # the files are those listed (no network needed)
    python tests/javascript/vendored.py --upstream             # and those of the npm packages
    python tests/javascript/vendored.py --update three@0.181.0 # take another version, and rewrite the list

Each entry of the list has the npm package, its version and licence, and for each file its path in the package and its
SHA-256. ``replace`` lists what is replaced in scripts: the page is not built, so their imports need relative
paths. After an update, install the same version of the types (``tests/javascript/package.json``) and run the tests in
``interop/web``.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

VENDOR = Path(__file__).resolve().parents[2] / "src/pyros1/web/page/vendor"
LIST = "versions.json"


def read_list(vendor: Path = VENDOR) -> list[dict[str, Any]]:
    """Return the entries of the list."""
    found: list[dict[str, Any]] = json.loads((vendor / LIST).read_text(encoding="utf-8"))
    return found


def problems(vendor: Path = VENDOR) -> Iterator[str]:
    """Yield what is wrong with the files: changed, missing, not listed, or without a licence."""
    listed = {LIST}
    for library in read_list(vendor):
        if not any(name.endswith(".LICENSE") for name in library["files"]):
            yield f"{library['package']}: no licence is among its files"
        for name, facts in library["files"].items():
            listed.add(name)
            if not (vendor / name).is_file():
                yield f"{name}: is missing"
            elif sha256((vendor / name).read_bytes()) != facts["sha256"]:
                yield f"{name}: is not the file of {library['package']} {library['version']} that {LIST} lists"
    for path in sorted(vendor.rglob("*")):
        if path.is_file() and (name := path.relative_to(vendor).as_posix()) not in listed:
            yield f"{name}: is not in {LIST}"


def differences_from_npm(vendor: Path = VENDOR) -> Iterator[str]:
    """Yield the files that differ from those of the listed packages, which npm downloads."""
    for library in read_list(vendor):
        files, _ = download(library, library["version"])
        for name, content in files.items():
            if (vendor / name).read_bytes() != content:
                yield f"{name}: differs from {library['package']} {library['version']}"


def update(package: str, version: str, vendor: Path = VENDOR) -> str:
    """Write the files of a version of a listed package, and the list. Return the version that npm found.

    Args:
        package: the name of a listed package.
        version: a version, or a tag such as ``latest``.
        vendor: the folder.

    Raises:
        KeyError: the package is not listed.
    """
    libraries = read_list(vendor)
    library = next((each for each in libraries if each["package"] == package), None)
    if library is None:
        raise KeyError(package)
    files, manifest = download(library, version)
    library.update(version=manifest["version"], licence=manifest["license"])
    for name, content in files.items():
        (vendor / name).write_bytes(content)
        library["files"][name]["sha256"] = sha256(content)
    (vendor / LIST).write_text(json.dumps(libraries, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    return str(manifest["version"])


def download(library: dict[str, Any], version: str) -> tuple[dict[str, bytes], dict[str, Any]]:
    """Return the files of a package as they are vendored, by name, and its ``package.json``."""
    with tempfile.TemporaryDirectory() as folder:
        command = ["npm", "pack", "--silent", f"{library['package']}@{version}", "--pack-destination", folder]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, timeout=300)
        [archive] = Path(folder).glob("*.tgz")
        with tarfile.open(archive) as tar:
            manifest = json.loads(member(tar, "package.json"))
            files = {name: member(tar, facts["source"]) for name, facts in library["files"].items()}
    return {name: adapted(name, content, library) for name, content in files.items()}, manifest


def member(tar: tarfile.TarFile, name: str) -> bytes:
    """Return the content of a file of a package."""
    file = tar.extractfile(f"package/{name}")
    assert file is not None, f"{name} is not a file"
    return file.read()


def adapted(name: str, content: bytes, library: dict[str, Any]) -> bytes:
    """Return a script with its imports adapted and without the address of a source map, which is not vendored."""
    if not name.endswith(".js"):
        return content
    text = content.decode()
    for old, new in library.get("replace", {}).items():
        text = text.replace(old, new)
    return re.sub(r"//# sourceMappingURL=\S+\n?\Z", "", text).encode()


def sha256(content: bytes) -> str:
    """Return the SHA-256 as hexadecimal digits."""
    return hashlib.sha256(content).hexdigest()


def main(arguments: list[str] | None = None) -> int:
    """Run the command; see the module's documentation."""
    parser = argparse.ArgumentParser(
        description="Verify or update the JavaScript libraries in the page's vendor folder."
    )
    parser.add_argument("--upstream", action="store_true", help="compare the files with the npm packages, too")
    parser.add_argument("--update", metavar="PACKAGE@VERSION", nargs="+", default=[], help="take these versions")
    options = parser.parse_args(arguments)
    for wanted in options.update:
        package, _, version = wanted.rpartition("@")
        if not package:
            parser.error(f"{wanted}: write PACKAGE@VERSION, or PACKAGE@latest")
        try:
            print(f"{package} {update(package, version)}")
        except KeyError:
            parser.error(f"{package} is not in {VENDOR / LIST}")
    found = list(problems())
    if options.upstream and not found:
        found = list(differences_from_npm())
    print(*found, sep="\n", end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
