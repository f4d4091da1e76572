"""Keys and certificates by which sites prove their identity to each other (mutual TLS).

`make_keys` makes a folder like this::

    keys/ca/     ca.crt ca.key               the certificate authority; its key belongs to no site
    keys/red/    ca.crt site.crt site.key    what site `red` needs: copy this folder there

A site's certificate has the site's name as common name, and the host names and addresses at which other sites connect
to it as alternative names. `load_keys` checks such a folder before it is used. A site's later keys have a number in
their name, such as ``red-2``: zenoh does not support certificate revocation lists, so whoever admits a site must know
the name of its current keys.
"""

from __future__ import annotations

import ipaddress
import os
import shutil
import stat
from collections.abc import Mapping, Sequence
from datetime import datetime, timedelta, timezone
from importlib import import_module
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from pyros1.bridge.names import SiteNameError, site_of_key_name
from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line

if TYPE_CHECKING:
    from cryptography import x509
    from cryptography.hazmat.primitives.asymmetric import ec

DEFAULT_DAYS = 3650
"""Days for which certificates are valid. Sites cannot renew them by themselves, so this covers a robot's lifetime."""
EXPIRY_WARNING_DAYS = 60
AUTHORITY = "ca"
"""Name of the certificate authority's folder; no site may have this name."""
CA_CERTIFICATE, SITE_CERTIFICATE, SITE_KEY = "ca.crt", "site.crt", "site.key"
_CA_KEY = "ca.key"
_MAX_DAYS = 36500
_CLOCK_ERROR = timedelta(days=1)
"""Maximum time by which a site's clock may be behind."""
_MAX_FILE_SIZE = 1 << 20


class KeysError(Error):
    """Keys cannot be made or used; the message names the file and says what to do."""


class SiteKeys(NamedTuple):
    """The keys of a site, which have been checked.

    Attributes:
        site: the site's name.
        name: the name in the certificate: the site's name, or for later keys one such as ``red-2``.
        ca_certificate, certificate, key: the files.
        expires: when the first of the certificates expires, in UTC.
    """

    site: str
    name: str
    ca_certificate: Path
    certificate: Path
    key: Path
    expires: datetime

    def days_left(self, now: datetime | None = None) -> int:
        """Return the number of whole days until the first of the certificates expires."""
        return (self.expires - (now or _now())).days


def make_keys(folder: Path, hosts: Mapping[str, Sequence[str]], days: int = DEFAULT_DAYS) -> list[Path]:
    """Make keys for sites, and a certificate authority if the folder has none yet.

    Args:
        folder: where to put them; other users cannot access it.
        hosts: for each site, or later keys of a site such as ``red-2``, the host names and IP addresses at which other
            sites connect to it; empty for a site that only connects to others.
        days: for how many days the certificates are valid.

    Returns:
        The new folders, one for each site.

    Raises:
        SiteNameError: a site cannot have this name. KeysError: a host is invalid, or a site already has keys; or a file
        cannot be read or written. Only in the last case may keys have been made for some of the sites.
    """
    if not 1 <= days <= _MAX_DAYS:
        raise KeysError(f"certificates can be valid for 1 to {_MAX_DAYS} days, not for {days}")
    for site, names in hosts.items():
        _check_site(site)
        if (folder / site).exists():
            raise KeysError(
                f"{one_line(str(folder / site))} already exists; to make keys that replace these, name them "
                f"{_next_name(folder, site)}"
            )
        for name in names:
            _alternative_name(name)
    authority = folder / AUTHORITY
    if not authority.exists() and any(folder.glob(f"*/{SITE_CERTIFICATE}")):
        raise KeysError(
            f"{one_line(str(folder))} has keys of sites, but not {AUTHORITY}, which has issued them, so these sites "
            f"would refuse new ones: copy {AUTHORITY} back into it, or name a new folder and make the keys of all sites"
        )
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not authority.exists():
            _make_authority(authority)
        certificate, key = _load_authority(authority)
        return [_make_site(folder / site, names, certificate, key, days) for site, names in hosts.items()]
    except OSError as error:
        raise KeysError(f"{one_line(str(error.filename or folder))}: {error.strerror}") from None


def _check_site(name: str) -> None:
    if site_of_key_name(name) == AUTHORITY:
        raise SiteNameError(f"{name!r} cannot be a site's name: it is the certificate authority's folder")


def _next_name(folder: Path, name: str) -> str:
    site = site_of_key_name(name)
    return next(f"{site}-{number}" for number in count(2) if not (folder / f"{site}-{number}").exists())


def load_keys(folder: Path, now: datetime | None = None) -> SiteKeys:
    """Check the keys of a site.

    Args:
        folder: a site's folder, as made by `make_keys`.
        now: the time at which the keys must be valid; by default, the current time.

    Raises:
        KeysError: a file is missing, unreadable for this user or readable for others; the certificate has expired, is
            not yet valid, does not belong to the key, or was not issued by this authority.
    """
    paths = [folder / name for name in (CA_CERTIFICATE, SITE_CERTIFICATE, SITE_KEY)]
    if not paths[1].exists() and (sites := sorted(path.parent.name for path in folder.glob(f"*/{SITE_CERTIFICATE}"))):
        raise KeysError(
            f"{one_line(str(folder))} has the keys of several sites: give the folder of this one, such as "
            f"{one_line(str(folder / sites[0]))}"
        )
    if missing := [path.name for path in paths if not path.exists()]:
        raise KeysError(
            f"{one_line(str(folder))} has no {' and no '.join(missing)}: make keys with `pyros1 bridge keys`, and give "
            "this site's folder, copied as a whole"
        )
    ca_path, certificate_path, key_path = paths
    authority, certificate = (_load_certificate(path) for path in (ca_path, certificate_path))
    key = _load_key(key_path)
    if _public_bytes(key.public_key()) != _public_bytes(certificate.public_key()):
        raise KeysError(f"{one_line(str(key_path))} is not the key of {SITE_CERTIFICATE} next to it")
    try:
        certificate.verify_directly_issued_by(authority)
    except _invalid_key_errors():
        raise KeysError(f"{one_line(str(certificate_path))} was not issued by {CA_CERTIFICATE} next to it") from None
    moment = now or _now()
    for path, each in ((ca_path, authority), (certificate_path, certificate)):
        if moment > each.not_valid_after_utc:
            raise KeysError(
                f"{one_line(str(path))} expired on {each.not_valid_after_utc:%Y-%m-%d}; make new keys with "
                "`pyros1 bridge keys`"
            )
        if moment < each.not_valid_before_utc:
            raise KeysError(
                f"{one_line(str(path))} is not valid before {each.not_valid_before_utc:%Y-%m-%d}; is this machine's "
                "clock right?"
            )
    expires = min(authority.not_valid_after_utc, certificate.not_valid_after_utc)
    name = _common_name(certificate, certificate_path)
    return SiteKeys(site_of_key_name(name), name, ca_path, certificate_path, key_path, expires)


def _make_authority(folder: Path) -> None:
    x509 = _import("x509")
    key = _new_key()
    name = _name("pyros1 sites")
    usage = _key_usage(key_cert_sign=True, crl_sign=True)
    builder = _certificate_builder(name, name, key, _MAX_DAYS).add_extension(
        x509.BasicConstraints(ca=True, path_length=0), critical=True
    )
    certificate = builder.add_extension(usage, critical=True).sign(key, _import("hazmat.primitives.hashes").SHA256())
    _write_folder(folder, {CA_CERTIFICATE: _pem(certificate), _CA_KEY: _private_pem(key)})


def _make_site(
    folder: Path,
    hosts: Sequence[str],
    authority: x509.Certificate,
    authority_key: ec.EllipticCurvePrivateKey,
    days: int,
) -> Path:
    x509 = _import("x509")
    oids = _import("x509.oid").ExtendedKeyUsageOID
    key = _new_key()
    builder = (
        _certificate_builder(_name(folder.name), authority.subject, key, days)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(_key_usage(digital_signature=True), critical=True)
        .add_extension(x509.ExtendedKeyUsage([oids.SERVER_AUTH, oids.CLIENT_AUTH]), critical=False)
    )
    if hosts:
        names = x509.SubjectAlternativeName([_alternative_name(host) for host in hosts])
        builder = builder.add_extension(names, critical=False)
    certificate = builder.sign(authority_key, _import("hazmat.primitives.hashes").SHA256())
    contents = {CA_CERTIFICATE: _pem(authority), SITE_CERTIFICATE: _pem(certificate), SITE_KEY: _private_pem(key)}
    _write_folder(folder, contents)
    return folder


def _certificate_builder(subject: Any, issuer: Any, key: ec.EllipticCurvePrivateKey, days: int) -> Any:
    x509 = _import("x509")
    return x509.CertificateBuilder(
        issuer_name=issuer,
        subject_name=subject,
        public_key=key.public_key(),
        serial_number=x509.random_serial_number(),
        not_valid_before=_now() - _CLOCK_ERROR,
        not_valid_after=_now() + timedelta(days=days),
    )


def _key_usage(**true: bool) -> Any:
    names = "digital_signature content_commitment key_encipherment data_encipherment key_agreement key_cert_sign "
    names += "crl_sign encipher_only decipher_only"
    return _import("x509").KeyUsage(**{**dict.fromkeys(names.split(), False), **true})


def _alternative_name(host: str) -> Any:
    """Return a host name or an IP address as a name in a certificate; raises KeysError if it is neither."""
    x509 = _import("x509")
    try:
        return x509.IPAddress(ipaddress.ip_address(host))
    except ValueError:
        pass
    labels = host.removesuffix(".").split(".")
    # If the last label has only digits, it is a mistyped address, such as 10.0.0.300.
    if (
        len(host) > 253
        or labels[-1].isdigit()
        or not all(
            0 < len(label) <= 63 and label.isascii() and label.replace("-", "a").isalnum() and label.strip("-") == label
            for label in labels
        )
    ):
        raise KeysError(f"{one_line(host)!r} is neither a host name nor an IP address")
    return x509.DNSName(host)


def _name(common_name: str) -> Any:
    x509 = _import("x509")
    return x509.Name([x509.NameAttribute(_import("x509.oid").NameOID.COMMON_NAME, common_name)])


def _common_name(certificate: x509.Certificate, path: Path) -> str:
    values = [
        each.value for each in certificate.subject.get_attributes_for_oid(_import("x509.oid").NameOID.COMMON_NAME)
    ]
    try:
        (name,) = map(str, values)
        site_of_key_name(name)
        return name
    except ValueError:
        raise KeysError(f"{one_line(str(path))} does not name a site; make keys with `pyros1 bridge keys`") from None


def _new_key() -> ec.EllipticCurvePrivateKey:
    curves = _import("hazmat.primitives.asymmetric.ec")
    key: ec.EllipticCurvePrivateKey = curves.generate_private_key(curves.SECP256R1())
    return key


def _pem(certificate: x509.Certificate) -> bytes:
    return certificate.public_bytes(_import("hazmat.primitives.serialization").Encoding.PEM)


def _private_pem(key: ec.EllipticCurvePrivateKey) -> bytes:
    forms = _import("hazmat.primitives.serialization")
    return key.private_bytes(forms.Encoding.PEM, forms.PrivateFormat.PKCS8, forms.NoEncryption())


def _public_bytes(key: Any) -> bytes:
    forms = _import("hazmat.primitives.serialization")
    encoded: bytes = key.public_bytes(forms.Encoding.DER, forms.PublicFormat.SubjectPublicKeyInfo)
    return encoded


def _load_authority(folder: Path) -> tuple[x509.Certificate, ec.EllipticCurvePrivateKey]:
    certificate, key = _load_certificate(folder / CA_CERTIFICATE), _load_key(folder / _CA_KEY)
    if _public_bytes(key.public_key()) != _public_bytes(certificate.public_key()):
        raise KeysError(f"{one_line(str(folder / _CA_KEY))} is not the key of {CA_CERTIFICATE} next to it")
    return certificate, key


def _load_certificate(path: Path) -> x509.Certificate:
    data = _read(path)
    try:
        certificate: x509.Certificate = _import("x509").load_pem_x509_certificate(data)
    except _invalid_key_errors():
        raise KeysError(f"{one_line(str(path))} is not a certificate") from None
    return certificate


def _load_key(path: Path) -> ec.EllipticCurvePrivateKey:
    data = _read(path, secret=True)
    try:
        key: ec.EllipticCurvePrivateKey = _import("hazmat.primitives.serialization").load_pem_private_key(data, None)
    except _invalid_key_errors():
        raise KeysError(f"{one_line(str(path))} is not a private key without a passphrase") from None
    return key


def _read(path: Path, secret: bool = False) -> bytes:
    try:
        if path.exists() and not path.is_file():
            raise KeysError(f"{one_line(str(path))} is not a file")
        with path.open("rb") as stream:
            status = os.fstat(stream.fileno())
            if secret and os.name == "posix" and status.st_mode & (stat.S_IRWXG | stat.S_IRWXO):
                raise KeysError(
                    f"{one_line(str(path))} can be read by other users; run: chmod 600 {one_line(str(path))}"
                )
            return stream.read(_MAX_FILE_SIZE)
    except OSError as error:
        raise KeysError(f"{one_line(str(path))}: {error.strerror}") from None


def _write_folder(folder: Path, contents: Mapping[str, bytes]) -> None:
    """Make a folder with files that only this user can read, completely or not at all."""
    partial = folder.with_name(f".{folder.name}.{os.getpid()}.part")
    partial.mkdir(mode=0o700)
    try:
        for name, data in contents.items():
            descriptor = os.open(partial / name, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            with open(descriptor, "wb") as stream:
                stream.write(data)
        partial.rename(folder)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise


def _invalid_key_errors() -> tuple[type[Exception], ...]:
    errors = _import("exceptions")
    return (ValueError, TypeError, errors.InvalidSignature, errors.UnsupportedAlgorithm)  # TypeError: for a passphrase


def _now() -> datetime:
    return datetime.now(timezone.utc)


def _import(module: str) -> Any:
    try:
        return import_module(f"cryptography.{module}")
    except ImportError:
        raise KeysError("keys need a package: pip install 'pyros1[bridge]'") from None
