"""``bag encrypt`` and ``bag decrypt``: rewrite bags with or without encryption (L144)."""

from __future__ import annotations

from typing import Any

from pyros1.bag.edit import editing as edit
from pyros1.bag.format.encryption import AES_ENCRYPTOR, ENCRYPTORS, Cipher, KeyUnavailableError, new_cipher
from pyros1.bag.format.reader import BagReader
from pyros1.cli.commands.bag._options import compression_options
from pyros1.cli.commands.bag._writing.rewrite import BAGS_ARGUMENT, REWRITE_OPTIONS, REWRITE_USAGE, rewrite_each
from pyros1.cli.failures import CommandError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Option, Verb
from pyros1.cli.shared.progress import Progress


def encrypt(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Rewrite bags, encrypted for a gpg user. Return the exit code."""
    if options.plugin not in ENCRYPTORS:
        hint = did_you_mean(options.plugin, ENCRYPTORS)
        raise CommandError(f"unknown encryptor {options.plugin!r}{hint}; known encryptors: {', '.join(ENCRYPTORS)}")
    return _rewrite_bags(options, args, options.param if options.plugin == AES_ENCRYPTOR else None)


def decrypt(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Rewrite bags without encryption. Return the exit code."""
    return _rewrite_bags(options, args, None)


VERBS = [
    Verb(
        "encrypt",
        "encrypt one or more bag files",
        *REWRITE_OPTIONS,
        Option(
            "-p", "--plugin", default=AES_ENCRYPTOR, metavar="PLUGIN", help="encryptor plugin name (Default: %default)"
        ),
        Option(
            "-r",
            "--param",
            default="*",
            metavar="PARAM",
            help="encryptor plugin parameter: the gpg user whose public key is used "
            "(Default: %default, gpg's default key)",
        ),
        *compression_options("none"),
        BAGS_ARGUMENT,
        usage=REWRITE_USAGE,
        description="Encrypt one or more bag files.",
        examples=[("-r robot@example.com run.bag", "encrypt a bag so that only robot@example.com can decrypt it")],
        run=encrypt,
    ),
    Verb(
        "decrypt",
        "decrypt one or more bag files",
        *REWRITE_OPTIONS,
        *compression_options("none"),
        BAGS_ARGUMENT,
        usage=REWRITE_USAGE,
        description="Decrypt one or more bag files.",
        examples=[("run.bag", "decrypt a bag with your secret gpg key")],
        run=decrypt,
    ),
]


def _rewrite_bags(options: Any, paths: list[str], user: str | None) -> int:
    """Rewrite bags, encrypted for a gpg user, or unencrypted if `user` is None."""

    def rewrite_bag(source: str, target: str) -> None:
        with BagReader(source) as bag, Progress(source, bag.content_size(), quiet=options.quiet) as progress:
            messages = bag.messages()
            edit.copy(messages, target, compression=options.compression, cipher=_make_cipher(user), progress=progress)

    return rewrite_each(options, paths, rewrite_bag)


def _make_cipher(user: str | None) -> Cipher | None:
    """Return a cipher with a new key; None if `user` is None."""
    try:
        return None if user is None else new_cipher(user)
    except KeyUnavailableError as error:
        raise CommandError(str(error)) from None
