"""Encrypted bags (L144): stock rosbag reads what `pyros1 bag encrypt` makes, and we what it makes, with a real gpg.

Feature: encrypted bags -- `pyros1 bag encrypt, decrypt` (extra `encryption`, and gpg)
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness import SOURCE, STOCK_PYTHON

MAKER = Path(__file__).resolve().parents[1] / "peers" / "stock_bags.py"
KEY = """%no-protection
Key-Type: RSA
Key-Length: 2048
Subkey-Type: RSA
Subkey-Length: 2048
Name-Real: Robot
Name-Email: robot@example.com
Expire-Date: 0
%commit
"""
NAMES = ["plain", "bz2"]

pytestmark = pytest.mark.ours_only


@pytest.fixture(scope="module")
def keys() -> Iterator[Path]:
    """A folder of gpg with a key of its own; its path is short, since that of gpg's socket must be."""
    folder = Path(tempfile.mkdtemp(prefix="gpg"))
    environ = {**os.environ, "GNUPGHOME": str(folder)}
    try:
        subprocess.run(
            ["gpg", "--batch", "--quiet", "--gen-key"],
            input=KEY,
            env=environ,
            text=True,
            check=True,
            timeout=60,
            capture_output=True,
        )
        yield folder
    finally:
        subprocess.run(["gpgconf", "--kill", "all"], env=environ, check=False, timeout=20)
        shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Bags that stock made."""
    folder = tmp_path_factory.mktemp("bags")
    call([STOCK_PYTHON, MAKER, folder], folder)
    return folder


def call(words: list[object], folder: Path, **environ: object) -> subprocess.CompletedProcess[str]:
    result = subprocess.run(
        [str(word) for word in words],
        capture_output=True,
        text=True,
        cwd=folder,
        timeout=60,
        check=False,
        stdin=subprocess.DEVNULL,
        env={**os.environ, **{name: str(value) for name, value in environ.items()}},
    )
    assert "Traceback" not in result.stderr
    return result


def stock(folder: Path, keys: Path, *words: object) -> subprocess.CompletedProcess[str]:
    return call(["rosbag", *words], folder, GNUPGHOME=keys)


def ours(folder: Path, keys: Path, *words: object) -> subprocess.CompletedProcess[str]:
    return call([sys.executable, "-m", "pyros1", "bag", *words], folder, GNUPGHOME=keys, PYTHONPATH=SOURCE)


def dump(folder: Path, keys: Path, name: str) -> list[str]:
    """All messages of a bag with their connection headers, as stock reads them, sorted."""
    result = call([STOCK_PYTHON, MAKER, "dump", name], folder, GNUPGHOME=keys)
    assert result.returncode == 0, result.stderr
    return sorted(result.stdout.splitlines())


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("encryptor", "reader"), [(ours, stock), (stock, ours)], ids=["ours first", "stock first"])
def test_one_decrypts_what_the_other_encrypted(
    bags: Path, keys: Path, tmp_path: Path, encryptor: object, reader: object, name: str
) -> None:
    assert callable(encryptor) and callable(reader)
    shutil.copy(bags / f"{name}.bag", tmp_path / "x.bag")
    before = dump(tmp_path, keys, "x.bag")
    options = ["--lz4"] if name == "bz2" else []
    assert encryptor(tmp_path, keys, "encrypt", "-q", *options, "x.bag").returncode == 0
    secret = (tmp_path / "x.bag").read_bytes()
    assert b"rosbag/AesCbcEncryptor" in secret and b"std_msgs" not in secret
    mine, theirs = (tool(tmp_path, keys, "info", "x.bag") for tool in (ours, stock))
    assert mine.stdout == theirs.stdout and "GPG key user: Robot" in mine.stdout
    assert dump(tmp_path, keys, "x.bag") == before
    assert reader(tmp_path, keys, "decrypt", "-q", "-f", "x.bag").returncode == 0
    assert b"Encryptor" not in (tmp_path / "x.bag").read_bytes()
    assert dump(tmp_path, keys, "x.bag") == before


def test_without_the_key(bags: Path, keys: Path, tmp_path: Path) -> None:
    shutil.copy(bags / "plain.bag", tmp_path / "x.bag")
    assert ours(tmp_path, keys, "encrypt", "-q", "-r", "Robot", "x.bag").returncode == 0
    nobody = Path(tempfile.mkdtemp(prefix="gpg"))
    try:
        result = ours(tmp_path, nobody, "info", "x.bag")
        assert (result.returncode, result.stdout) == (1, "") and "No secret key" in result.stderr
        result = ours(tmp_path, nobody, "encrypt", "x.orig.bag")
        assert result.returncode == 1 and "gpg --gen-key" in result.stderr
        result = ours(tmp_path, nobody, "encrypt", "-r", "Nobody", "x.orig.bag")
        assert result.returncode == 1 and "gpg: " in result.stderr
    finally:
        call(["gpgconf", "--kill", "all"], tmp_path, GNUPGHOME=nobody)
        shutil.rmtree(nobody, ignore_errors=True)
