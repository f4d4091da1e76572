"""Keys of sites, as `ssl` and `load_keys` see them."""

from __future__ import annotations

import os
import ssl
import stat
from datetime import datetime, timedelta, timezone
from pathlib import Path

import pytest

from pyros1.bridge.names import SiteNameError
from pyros1.bridge.transport.certificates import KeysError, load_keys, make_keys

HOSTS = {"red": [], "base": ["base.example", "10.0.0.1", "::1"]}


@pytest.fixture
def keys(tmp_path: Path) -> Path:
    folder = tmp_path / "keys"
    make_keys(folder, HOSTS)
    return folder


def connect(client_folder: Path, server_folder: Path, host: str) -> tuple[str, str]:
    """Let a client and a server exchange certificates; return the site that each saw.

    Raises:
        ssl.SSLError: one of them refuses the other.
    """
    contexts = []
    for folder, purpose in ((client_folder, ssl.PROTOCOL_TLS_CLIENT), (server_folder, ssl.PROTOCOL_TLS_SERVER)):
        context = ssl.SSLContext(purpose)
        context.load_cert_chain(folder / "site.crt", folder / "site.key")
        context.load_verify_locations(folder / "ca.crt")
        context.verify_mode = ssl.CERT_REQUIRED
        contexts.append(context)
    to_client, to_server = ssl.MemoryBIO(), ssl.MemoryBIO()
    client = contexts[0].wrap_bio(to_client, to_server, server_hostname=host)
    server = contexts[1].wrap_bio(to_server, to_client, server_side=True)
    waiting = [client, server]
    for _ in range(20):
        for each in list(waiting):
            try:
                each.do_handshake()
                waiting.remove(each)
            except ssl.SSLWantReadError:
                pass
    assert not waiting
    names = []
    for each in (server, client):
        certificate = each.getpeercert()
        assert certificate
        ((pair,),) = certificate["subject"]  # type: ignore[misc]
        names.append(pair[1])
    return names[1], names[0]


@pytest.mark.parametrize("host", ["base.example", "10.0.0.1", "::1"])
def test_sites_know_each_other(keys: Path, host: str) -> None:
    assert connect(keys / "red", keys / "base", host) == ("base", "red")


@pytest.mark.parametrize("host", ["elsewhere.example", "10.0.0.2"])
def test_a_server_at_another_address_is_refused(keys: Path, host: str) -> None:
    with pytest.raises(ssl.SSLError, match=r"mismatch|not valid for"):
        connect(keys / "red", keys / "base", host)


def test_a_site_that_others_do_not_connect_to_cannot_be_a_server(keys: Path) -> None:
    with pytest.raises(ssl.SSLError):
        connect(keys / "base", keys / "red", "base.example")


def test_keys_of_another_authority_are_refused(keys: Path, tmp_path: Path) -> None:
    make_keys(tmp_path / "others", HOSTS)
    with pytest.raises(ssl.SSLError):
        connect(tmp_path / "others" / "red", keys / "base", "base.example")


def test_a_site_cannot_issue_certificates(keys: Path) -> None:
    """Otherwise a robot that was broken into could be all sites."""
    text = ssl.create_default_context(cafile=str(keys / "red" / "site.crt")).get_ca_certs()
    assert text == []  # it is none
    assert len(ssl.create_default_context(cafile=str(keys / "red" / "ca.crt")).get_ca_certs()) == 1


def test_a_site_is_added_later(keys: Path) -> None:
    assert make_keys(keys, {"green": []}) == [keys / "green"]
    assert connect(keys / "green", keys / "base", "base.example") == ("base", "green")


def test_existing_keys_are_kept(keys: Path) -> None:
    before = (keys / "red" / "site.key").read_bytes()
    with pytest.raises(KeysError, match=r"keys/red already exists; to make keys that replace these, name them red-2$"):
        make_keys(keys, {"green": [], "red": []})
    assert (keys / "red" / "site.key").read_bytes() == before
    assert not (keys / "green").exists()


def test_newer_keys_of_a_site(keys: Path) -> None:
    assert make_keys(keys, {"red-2": [], "base-7": ["base.example"]}) == [keys / "red-2", keys / "base-7"]
    found = load_keys(keys / "red-2")
    assert (found.site, found.name) == ("red", "red-2")
    assert (load_keys(keys / "red").site, load_keys(keys / "red").name) == ("red", "red")
    assert connect(keys / "red-2", keys / "base-7", "base.example") == ("base-7", "red-2")
    for name, proposal in (("red", "red-3"), ("red-2", "red-3"), ("base", "base-2"), ("base-7", "base-2")):
        with pytest.raises(KeysError, match=f"{name} already exists; .* name them {proposal}$"):
            make_keys(keys, {name: []})


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
def test_other_users_have_no_access(keys: Path) -> None:
    for path in (keys, *keys.rglob("*")):
        assert not path.stat().st_mode & (stat.S_IRWXG | stat.S_IRWXO), path


def test_loading(keys: Path) -> None:
    found = load_keys(keys / "base")
    assert found.site == "base"
    assert [found.ca_certificate, found.certificate, found.key] == [
        keys / "base" / name for name in ("ca.crt", "site.crt", "site.key")
    ]
    assert found.days_left(datetime.now(timezone.utc)) == 3649
    assert found.days_left(found.expires + timedelta(hours=1)) == -1


def swap(keys: Path, name: str, source: Path) -> None:
    (keys / "red" / name).write_bytes(source.read_bytes())


def test_keys_that_do_not_fit_are_refused(keys: Path, tmp_path: Path) -> None:
    make_keys(tmp_path / "others", HOSTS)
    original = (keys / "red" / "site.key").read_bytes()
    swap(keys, "site.key", keys / "base" / "site.key")
    with pytest.raises(KeysError, match=r"red/site\.key is not the key of site\.crt next to it"):
        load_keys(keys / "red")
    (keys / "red" / "site.key").write_bytes(original)
    swap(keys, "ca.crt", tmp_path / "others" / "red" / "ca.crt")
    with pytest.raises(KeysError, match=r"red/site\.crt was not issued by ca\.crt next to it"):
        load_keys(keys / "red")


@pytest.mark.parametrize(
    ("name", "content", "error"),
    [
        ("ca.crt", None, r"red has no ca\.crt: make keys with `pyros1 bridge keys`"),
        ("site.crt", b"nothing", r"red/site\.crt is not a certificate"),
        ("site.key", b"", r"red/site\.key is not a private key without a passphrase"),
        ("site.key", b"-----BEGIN PRIVATE KEY-----\nAAAA\n-----END PRIVATE KEY-----\n", r"is not a private key"),
        ("site.crt", b"-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n", r"is not a certificate"),
    ],
)
def test_damaged_files_are_named(keys: Path, name: str, content: bytes | None, error: str) -> None:
    path = keys / "red" / name
    if content is None:
        path.unlink()
    else:
        path.write_bytes(content)
    with pytest.raises(KeysError, match=error):
        load_keys(keys / "red")


def test_a_pipe_in_place_of_a_file_is_refused(keys: Path) -> None:
    if not hasattr(os, "mkfifo"):
        pytest.skip("no pipes")
    (keys / "red" / "ca.crt").unlink()
    os.mkfifo(keys / "red" / "ca.crt")
    with pytest.raises(KeysError, match="is not a file"):
        load_keys(keys / "red")


def test_a_key_that_others_can_read_is_refused(keys: Path) -> None:
    (keys / "red" / "site.key").chmod(0o640)
    with pytest.raises(KeysError, match=r"can be read by other users; run: chmod 600 .*site\.key"):
        load_keys(keys / "red")


def test_validity(keys: Path) -> None:
    now = datetime.now(timezone.utc)
    with pytest.raises(KeysError, match=r"site\.crt expired on \d{4}-\d\d-\d\d; make new keys"):
        load_keys(keys / "red", now + timedelta(days=3651))
    with pytest.raises(KeysError, match=r"ca\.crt expired on \d{4}-\d\d-\d\d; make new keys"):
        load_keys(keys / "red", now + timedelta(days=36501))
    with pytest.raises(KeysError, match=r"is not valid before .*clock"):
        load_keys(keys / "red", now - timedelta(days=2))
    load_keys(keys / "red", now - timedelta(hours=12))  # a clock that is a little behind


def test_keys_for_a_few_days_do_not_end_the_authority(tmp_path: Path) -> None:
    make_keys(tmp_path / "keys", {"guest": []}, days=10)
    make_keys(tmp_path / "keys", {"red": []})
    assert load_keys(tmp_path / "keys" / "red").days_left() == 3649
    assert load_keys(tmp_path / "keys" / "guest").days_left() == 9
    with pytest.raises(KeysError, match=r"guest/site\.crt expired"):
        load_keys(tmp_path / "keys" / "guest", datetime.now(timezone.utc) + timedelta(days=11))


@pytest.mark.parametrize(
    ("site", "hosts", "days", "error"),
    [
        ("ca", [], 1, "it is the certificate authority's folder"),
        ("ca-2", [], 1, "it is the certificate authority's folder"),
        ("red-0", [], 1, "newer keys of a site have a number after its name, such as red-2"),
        ("../red", [], 1, "cannot be a site's name"),
        ("", [], 1, "cannot be a site's name"),
        ("a" * 41, [], 1, "cannot be a site's name"),
        ("red", ["not a host"], 1, "'not a host' is neither a host name nor an IP address"),
        ("red", [""], 1, "neither a host name nor an IP address"),
        ("red", ["a..b"], 1, "neither a host name nor an IP address"),
        ("red", ["-a.example"], 1, "neither a host name nor an IP address"),
        ("red", ["b\u00fccher.example"], 1, "neither a host name nor an IP address"),
        ("red", ["10.0.0.300"], 1, "neither a host name nor an IP address"),
        ("red", ["1.2.3.4:7447"], 1, "neither a host name nor an IP address"),
        ("red", [], 0, "for 1 to 36500 days, not for 0"),
        ("red", [], 10**9, "for 1 to 36500 days"),
    ],
)
def test_bad_requests_make_nothing(tmp_path: Path, site: str, hosts: list[str], days: int, error: str) -> None:
    with pytest.raises((KeysError, SiteNameError), match=error):
        make_keys(tmp_path / "keys", {"first": [], site: hosts}, days)
    assert not (tmp_path / "keys").exists()


def test_a_folder_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(KeysError, match=r"Not a directory|exists"):
        make_keys(tmp_path / "file" / "keys", {"red": []})


def test_names_of_the_longest_length(tmp_path: Path) -> None:
    make_keys(tmp_path, {"a" * 40: ["b" * 63 + ".example"]})
    assert load_keys(tmp_path / ("a" * 40)).site == "a" * 40


def test_new_keys_need_the_authority_of_the_old_ones(keys: Path) -> None:
    (keys / "ca").rename(keys.parent / "kept")
    with pytest.raises(KeysError, match="copy ca back into it, or name a new folder"):
        make_keys(keys, {"green": []})
    (keys.parent / "kept").rename(keys / "ca")
    make_keys(keys, {"green": []})


def test_the_folder_of_all_keys_is_not_that_of_a_site(keys: Path) -> None:
    with pytest.raises(KeysError, match=f"give the folder of this one, such as {keys}/base$"):
        load_keys(keys)
