"""Encrypted bags (L144), with a gpg whose secret is who may read."""

from __future__ import annotations

import random
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from pyros1.bag.edit.reindex import reindex
from pyros1.bag.errors import EncryptedError
from pyros1.bag.format import encryption
from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.records import RecordError
from pyros1.cli.running import run_command

from ..conftest import Make, values

Run = Callable[..., tuple[int, str, str]]


class Gpg:
    """In the place of the program."""

    def __init__(self) -> None:
        self.has_key = True

    def __call__(self, *words: str, data: bytes = b"") -> bytes:
        if "--list-secret-keys" in words:
            return b"sec:u:\nfpr:::::::::F00D:\nuid:u::::::::Foo <foo@example.com>:\n" if self.has_key else b""
        if "--encrypt" in words:
            return b"locked" + data[::-1]
        if not self.has_key:
            raise encryption.KeyUnavailableError("gpg: decryption failed: No secret key")
        return data[len(b"locked") :][::-1]


@pytest.fixture
def gpg(monkeypatch: pytest.MonkeyPatch) -> Gpg:
    fake = Gpg()
    monkeypatch.setattr(encryption, "run_gpg", fake)
    return fake


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, call_main: Any, tmp_path: Path, gpg: Gpg) -> Run:
    monkeypatch.chdir(tmp_path)
    return partial(call_main, partial(run_command, "bag"))


@pytest.mark.parametrize("size", [0, 1, 15, 16, 17, 1000])
def test_what_was_encrypted_is_decrypted(gpg: Gpg, size: int) -> None:
    cipher = encryption.new_cipher("me")
    plain = random.Random(size).randbytes(size)
    secret = cipher.encrypt(plain)
    assert len(secret) % 16 == 0 and cipher.encrypt(plain) != secret
    assert encryption.open_cipher(cipher.fields).decrypt(secret) == plain
    assert plain.startswith(cipher.decrypt(secret[:-1], partial=True))
    for wrong in (b"", secret[:-1], secret[:16]):
        with pytest.raises(RecordError, match="cut off"):
            cipher.decrypt(wrong)
    other = encryption.new_cipher("me")
    with pytest.raises(RecordError, match="another key"):
        for _ in range(100):  # one in 256 looks right
            other.decrypt(cipher.encrypt(plain))


@pytest.mark.parametrize("compression", [[], ["-j"], ["--lz4"]], ids=str)
def test_encrypt_and_decrypt(run: Run, make_bag: Make, tmp_path: Path, compression: list[str]) -> None:
    path = make_bag(chunk_threshold=1 << 20)
    with BagReader(path) as bag:
        before = dict(bag.connections)
    assert run("encrypt", *compression, "x.bag") == (0, "", "")
    data = path.read_bytes()
    assert b"rosbag/AesCbcEncryptor" in data and b"std_msgs/String" not in data and b"callerid" not in data
    assert (tmp_path / "x.orig.bag").exists()
    assert values(path, unindexed=False) == list(range(100))
    with BagReader(path) as bag:
        assert bag.connections == before
    assert "encryption:   rosbag/AesCbcEncryptor\nGPG key user: Foo\n" in run("info", "x.bag")[1]
    assert run("decrypt", "-f", "x.bag") == (0, "", "")
    assert b"Encryptor" not in path.read_bytes()
    assert values(path, unindexed=False) == list(range(100))


def test_without_the_key_nothing_is_read_or_changed(run: Run, gpg: Gpg, make_bag: Make, tmp_path: Path) -> None:
    make_bag()
    (tmp_path / "secret").mkdir()
    assert run("encrypt", "--output-dir", "secret", "x.bag")[0] == 0
    path = tmp_path / "secret" / "x.bag"
    gpg.has_key = False
    with pytest.raises(EncryptedError, match=r"encrypted and cannot be decrypted: gpg: .*No secret key"):
        BagReader(path)
    before = path.read_bytes()
    for verb in (["info"], ["decrypt"], ["compress"], ["reindex"]):
        code, out, err = run(*verb, path)
        assert (code, out) == (1, "") and "No secret key" in err
    assert path.read_bytes() == before and [p.name for p in path.parent.iterdir()] == ["x.bag"]


@pytest.mark.parametrize("compression", ["none", "lz4"])
def test_an_encrypted_bag_that_is_cut_off_is_saved_and_stays_encrypted(
    run: Run, make_bag: Make, tmp_path: Path, compression: str
) -> None:
    path = make_bag(compression=compression)
    run("encrypt", *(["--lz4"] if compression == "lz4" else []), "x.bag")
    whole = path.read_bytes()
    for size in random.Random(3).sample(range(4117, len(whole)), 10):
        path.write_bytes(whole[:size])
        saved = reindex(path, tmp_path / "new.bag")
        found = values(tmp_path / "new.bag", unindexed=False) if saved.messages else []
        assert found == list(range(saved.messages)) == values(path)
        assert b"std_msgs" not in (tmp_path / "new.bag").read_bytes()


def test_without_the_package_a_line_says_what_to_do(run: Run, make_bag: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    make_bag()
    monkeypatch.setitem(sys.modules, "cryptography.hazmat.primitives.ciphers", None)
    code, out, err = run("encrypt", "x.bag")
    assert (code, out) == (1, "") and "pip install 'pyros1[encryption]'" in err


def test_without_gpg_a_line_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    with pytest.raises(encryption.KeyUnavailableError, match=r"gpg \(GnuPG\), which is not installed"):
        encryption.new_cipher("me")


def test_wrong_plugins(run: Run, make_bag: Make, tmp_path: Path) -> None:
    make_bag()
    code, _, err = run("encrypt", "-p", "rosbag/AesCbcEncrypter", "x.bag")
    assert code == 1 and "did you mean" in err.lower()
    assert run("encrypt", "-p", "rosbag/NoEncryptor", "x.bag") == (0, "", "")
    assert values(tmp_path / "x.bag", unindexed=False) == list(range(100))
    with pytest.raises(EncryptedError, match="other/Plugin, which is not supported"):
        data = (tmp_path / "x.orig.bag").read_bytes()
        from pyros1.bag.format.records import make_bag_header

        (tmp_path / "y.bag").write_bytes(data[:13] + make_bag_header(0, 0, 0, {"encryptor": b"other/Plugin"}))
        BagReader(tmp_path / "y.bag")


def test_what_is_made_of_an_encrypted_bag_is_encrypted(run: Run, make_bag: Make, tmp_path: Path) -> None:
    make_bag()
    run("encrypt", "x.bag")
    for words in (
        ["filter", "x.bag", "new.bag", "True"],
        ["merge", "new.bag", "x.bag"],
        ["rename-topic", "x.bag", "new.bag", "/a", "/c"],
        ["retime", "x.bag", "new.bag", "--offset", "1"],
        ["fix", "x.bag", "new.bag"],
        ["split", "x.bag", "--count", "1000"],
        ["compress", "-f", "x.bag"],
    ):
        assert run(*words)[0] == 0
        for path in set(tmp_path.glob("*.bag")) - {tmp_path / "x.orig.bag"}:
            assert b"std_msgs" not in path.read_bytes() and values(path, unindexed=False) == list(range(100))
            if path.name != "x.bag":
                path.unlink()
