"""Encrypted bags (B03, L144): AES-CBC with one key per bag; the bag header holds the key, encrypted by gpg.

The cipher is implemented by the package ``cryptography``; gpg is the installed program, with the user's keys.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from importlib import import_module
from io import BytesIO
from typing import Any

from pyros1.bag.format.records import RecordError
from pyros1.ground.errors import Error

AES_ENCRYPTOR = "rosbag/AesCbcEncryptor"
NO_ENCRYPTOR = "rosbag/NoEncryptor"
ENCRYPTORS = (AES_ENCRYPTOR, NO_ENCRYPTOR)

_BLOCK_SIZE = 16
_PIECE_SIZE = 1 << 20
"""Number of bytes that are encrypted or decrypted at a time, since ``cryptography`` copies them."""

Buffer = bytes | bytearray | memoryview
_DEFAULT_USER = "*"


class KeyUnavailableError(Error):
    """A bag's key is not available; the message says why and what to do."""


class Cipher:
    """Encrypts and decrypts the chunks and connection headers of a bag.

    Args:
        fields: the fields of the bag header that describe the encryption.
        key: 16 bytes.

    Raises:
        KeyUnavailableError: the package ``cryptography`` is not installed, or the key is not valid.
    """

    def __init__(self, fields: Mapping[str, bytes], key: bytes) -> None:
        self.fields = fields
        ciphers = _import_ciphers()
        try:
            algorithm: Any = ciphers.algorithms.AES(key)
        except ValueError:
            raise KeyUnavailableError(f"the bag's key has {len(key)} bytes, which is not a key size of AES") from None
        self._make_cipher: Callable[[bytes], Any] = lambda vector: ciphers.Cipher(algorithm, ciphers.modes.CBC(vector))

    def encrypt(self, data: bytes) -> bytes:
        """Return the encrypted bytes, preceded by the initialization vector."""
        return b"".join(self.encrypt_parts([data]))

    def encrypt_parts(self, parts: Iterable[Buffer]) -> list[bytes]:
        """Return the encrypted bytes of the joined parts, in pieces; the first piece is the initialization vector."""
        vector = os.urandom(_BLOCK_SIZE)
        encryptor = self._make_cipher(vector).encryptor()
        output, size = [vector], 0
        for part in parts:
            output += map(encryptor.update, _split_into_pieces(memoryview(part)))
            size += len(part)
        padding = _BLOCK_SIZE - size % _BLOCK_SIZE
        return [*output, encryptor.update(bytes([padding]) * padding)]

    def decrypt(self, data: bytes, *, partial: bool = False) -> bytes:
        """Return the decrypted bytes.

        Args:
            partial: whether the data may be cut off; if so, the part that can be decrypted is returned.

        Raises:
            RecordError: the data were not encrypted with this key, or are damaged.
        """
        if partial:
            data = data[: len(data) // _BLOCK_SIZE * _BLOCK_SIZE]
        if len(data) < (1 if partial else 2) * _BLOCK_SIZE or len(data) % _BLOCK_SIZE:
            raise RecordError("the encrypted data are cut off")
        decryptor = self._make_cipher(data[:_BLOCK_SIZE]).decryptor()
        output = BytesIO()  # grows in place, and returns its bytes without copying them
        last_piece = b""
        for piece in _split_into_pieces(memoryview(data)[_BLOCK_SIZE:]):
            last_piece = decryptor.update(piece)
            output.write(last_piece)
        padding = last_piece[-1] if last_piece else 0
        if 0 < padding <= _BLOCK_SIZE and last_piece.endswith(bytes([padding]) * padding):
            output.truncate(len(data) - _BLOCK_SIZE - padding)
        elif not partial:
            raise RecordError("the encrypted data are damaged, or were encrypted with another key")
        return output.getvalue()


def _split_into_pieces(data: memoryview) -> Iterator[memoryview]:
    return (data[start : start + _PIECE_SIZE] for start in range(0, len(data), _PIECE_SIZE))


def new_cipher(user: str = _DEFAULT_USER) -> Cipher:
    """Return a cipher with a new key.

    Args:
        user: name, address or fingerprint of the gpg key that encrypts the new key; ``*`` for gpg's first secret key.

    Raises:
        KeyUnavailableError: gpg has no such key, or a program or package is not installed.
    """
    _import_ciphers()
    recipient, user_name = _first_secret_key() if user == _DEFAULT_USER else (user, user)
    key = os.urandom(_BLOCK_SIZE)
    encrypted_key = run_gpg("--batch", "--trust-model", "always", "--recipient", recipient, "--encrypt", data=key)
    return Cipher(
        {"encryptor": AES_ENCRYPTOR.encode(), "gpg_user": user_name.encode(), "encrypted_key": encrypted_key}, key
    )


def _first_secret_key() -> tuple[str, str]:
    """Return the fingerprint and user name of the user's first secret key."""
    fingerprint = ""
    for line in run_gpg("--batch", "--with-colons", "--list-secret-keys").decode(errors="replace").splitlines():
        fields = line.split(":")
        if fields[0] == "fpr" and not fingerprint:
            fingerprint = fields[9]
        if fields[0] == "uid" and fingerprint:
            return fingerprint, fields[9].partition(" <")[0]
    raise KeyUnavailableError("gpg has no secret key yet: create one with `gpg --gen-key`, or give another user's key")


def open_cipher(header: Mapping[str, bytes]) -> Cipher:
    """Return the cipher of an encrypted bag.

    Args:
        header: the fields of the bag header.

    Raises:
        KeyUnavailableError: the encryptor is unknown, gpg does not have the key, or a program or package is not
            installed.
    """
    encryptor = header.get("encryptor", b"").decode("latin-1")
    if encryptor != AES_ENCRYPTOR:
        raise KeyUnavailableError(f"the bag is encrypted by {encryptor}, which is not supported")
    fields = {name: header[name] for name in ("encryptor", "gpg_user", "encrypted_key") if name in header}
    _import_ciphers()  # first, so that a missing package is reported before the user is asked for a passphrase
    return Cipher(fields, run_gpg("--max-output", "4096", "--decrypt", data=header.get("encrypted_key", b"")))


def _import_ciphers() -> Any:
    try:
        return import_module("cryptography.hazmat.primitives.ciphers")
    except ImportError:
        raise KeyUnavailableError("encrypted bags need a package: pip install 'pyros1[encryption]'") from None


def run_gpg(*args: str, data: bytes = b"") -> bytes:
    """Run gpg with `data` as its input and return its output; raises KeyUnavailableError if gpg fails."""
    import subprocess  # noqa: PLC0415 - most bags are not encrypted

    try:
        result = subprocess.run(["gpg", "--quiet", *args], input=data, capture_output=True, check=False)
    except FileNotFoundError:
        raise KeyUnavailableError("encrypted bags need the program gpg (GnuPG), which is not installed") from None
    if result.returncode:
        lines = [line for line in result.stderr.decode(errors="replace").splitlines() if line.startswith("gpg: ")]
        raise KeyUnavailableError(lines[-1] if lines else f"gpg failed with exit code {result.returncode}")
    return result.stdout
