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
from pyros1.bag.format.writer import BagWriter
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


@pytest.fixture
def program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Puts a shell script in the place of gpg."""
    monkeypatch.setenv("PATH", str(tmp_path))

    def put(script: str) -> None:
        (tmp_path / "gpg").write_text(f"#!/bin/sh\n{script}\n")
        (tmp_path / "gpg").chmod(0o755)

    return put


def test_what_gpg_prints_is_the_encrypted_key(program: Callable[[str], None]) -> None:
    program('printf "%s " "$@"')
    fields = encryption.new_cipher("me").fields
    assert fields["encrypted_key"] == b"--quiet --batch --trust-model always --recipient me --encrypt "
    assert fields["gpg_user"] == b"me"


@pytest.mark.parametrize(
    ("says", "error"),
    [("gpg: a warning\\ngpg: No such key\\n", "gpg: No such key"), ("", "gpg failed with exit code 2")],
)
def test_what_gpg_says_when_it_fails(program: Callable[[str], None], says: str, error: str) -> None:
    program(f"printf '{says}' >&2\nexit 2")
    with pytest.raises(encryption.KeyUnavailableError, match=f"^{error}$"):
        encryption.new_cipher("me")


def test_without_a_secret_key_it_is_said_how_to_make_one(gpg: Gpg) -> None:
    gpg.has_key = False
    with pytest.raises(encryption.KeyUnavailableError, match="gpg has no secret key yet: create one with"):
        encryption.new_cipher()


def test_a_key_of_another_size(gpg: Gpg) -> None:
    fields = {"encryptor": b"rosbag/AesCbcEncryptor", "encrypted_key": gpg("--encrypt", data=b"short")}
    with pytest.raises(encryption.KeyUnavailableError, match="the bag's key has 5 bytes, which is not a key size of"):
        encryption.open_cipher(fields)


def test_an_encrypted_bag_with_a_damaged_index_is_scanned(gpg: Gpg, tmp_path: Path) -> None:
    """Of the index, the connections are whole; here they are not in a chunk, too."""
    header = {"topic": b"/x", "type": b"a/B", "md5sum": b"*", "message_definition": b""}
    with BagWriter(tmp_path / "x.bag", cipher=encryption.new_cipher("me")) as writer:
        conn = writer.put_connection("/x", header, None, in_chunk=False)
        writer.write(conn, 1, b"data")
    data = (tmp_path / "x.bag").read_bytes()
    (tmp_path / "x.bag").write_bytes(data.replace(b"chunk_pos=", b"chunk_xxx="))
    with BagReader(tmp_path / "x.bag", unindexed=True) as bag:
        assert bag.was_scanned and not bag.damaged_places
        assert [(message.connection.topic, message.data) for message in bag.messages()] == [("/x", b"data")]


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
