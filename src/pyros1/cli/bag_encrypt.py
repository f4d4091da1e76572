"""``bag encrypt`` and ``bag decrypt`` (L144)."""

from __future__ import annotations

from optparse import OptionParser

from pyros1.bag import edit
from pyros1.bag.encryption import AES, ENCRYPTORS, Cipher, KeyUnavailableError, new_cipher
from pyros1.bag.reader import BagReader
from pyros1.cli.bag_edit import add_compression, content_size, in_place_parser
from pyros1.cli.bag_files import rewrite_each
from pyros1.cli.common import CommandError, Invocation, did_you_mean
from pyros1.cli.shared.progress import Progress


def encrypt(invocation: Invocation) -> int:
    """``bag encrypt [options] BAG...``."""
    parser = in_place_parser(invocation, "Encrypt one or more bag files.")
    parser.add_option("-p", "--plugin", default=AES, metavar="PLUGIN", help="encryptor plugin name (Default: %default)")
    parser.add_option(
        "-r",
        "--param",
        default="*",
        metavar="PARAM",
        help="encryptor plugin parameter: whose public key of gpg is used (Default: %default, gpg's default key)",
    )
    add_compression(parser, "none")
    options, _ = parser.parse_args(invocation.args)
    if options.plugin not in ENCRYPTORS:
        hint = did_you_mean(options.plugin, ENCRYPTORS)
        raise CommandError(f"there is no encryptor {options.plugin!r}{hint}; there are {', '.join(ENCRYPTORS)}")
    return _rewrite(invocation, parser, options.param if options.plugin == AES else None)


def decrypt(invocation: Invocation) -> int:
    """``bag decrypt [options] BAG...``."""
    parser = in_place_parser(invocation, "Decrypt one or more bag files.")
    add_compression(parser, "none")
    return _rewrite(invocation, parser, None)


def _rewrite(invocation: Invocation, parser: OptionParser, user: str | None) -> int:
    """Make new bags of all given ones, encrypted for a user of gpg, or plain."""
    options, paths = parser.parse_args(invocation.args)
    if not paths:
        parser.error("You must specify at least one bag file.")

    def operation(source: str, target: str) -> None:
        with BagReader(source) as bag, Progress(source, content_size(bag), quiet=options.quiet) as progress:
            messages = bag.messages()
            edit.copy(messages, target, compression=options.compression, cipher=_cipher(user), progress=progress)

    return rewrite_each(
        paths, operation, output_dir=options.output_dir, force=bool(options.force), quiet=bool(options.quiet)
    )


def _cipher(user: str | None) -> Cipher | None:
    """A cipher with a key of its own for each bag."""
    try:
        return None if user is None else new_cipher(user)
    except KeyUnavailableError as error:
        raise CommandError(str(error)) from None
