"""Who may come in."""

from __future__ import annotations

import pytest

from pyros1.web.server.access import Access


@pytest.mark.parametrize(
    ("host", "ours"),
    [
        ("localhost:9090", True),
        ("LOCALHOST", True),
        ("127.0.0.1:1", True),
        ("[::1]:9090", True),
        ("robot:9090", True),
        ("evil.example", False),
        ("localhost.evil.example:9090", False),
        ("127.0.0.1.evil.example", False),
        ("192.168.1.5:9090", False),
        ("localhost:9090 evil", False),
        ("localhost:9090\n", False),
        ("user@localhost", False),
        ("", False),
        (None, False),
    ],
)
def test_names_of_the_server(host: str | None, ours: bool) -> None:
    assert Access(names={"robot"}).is_own_name(host) is ours


def test_any_address_but_no_name_of_others_when_it_listens_everywhere() -> None:
    access = Access(any_address=True)
    assert access.is_own_name("192.168.1.5:9090")
    assert access.is_own_name("[fe80::1]:9090")
    assert not access.is_own_name("evil.example:9090")


@pytest.mark.parametrize(
    ("origin", "ours"),
    [
        (None, True),
        ("http://localhost:9090", True),
        ("https://localhost:9090", True),
        ("http://localhost:9091", False),
        ("http://evil.example", False),
        ("null", False),
        ("file://localhost:9090", False),
        ("", False),
    ],
)
def test_pages_of_others(origin: str | None, ours: bool) -> None:
    assert Access().is_own_page(origin, "localhost:9090") is ours


def test_the_token() -> None:
    access = Access()
    assert len(access.token) >= 20
    assert access.token != Access().token
    assert not access.token_problem(f"/ws?token={access.token}")
    assert not access.token_problem(f"/ws?x=1&token={access.token}")
    for path in (
        "/ws",
        "/ws?token=",
        "/ws?token=wrong",
        f"/ws?token={access.token}x",
        "/ws?token=%ff",
        "/ws?token=\u00e9",
    ):
        assert "pyros1 web graph" in access.token_problem(path)
    assert not Access(token="").token_problem("/ws")
    assert access.token not in repr(access)


def test_too_many_parts_of_a_query_are_refused() -> None:
    assert "lacks its token" in Access().token_problem("/ws?" + "a=1&" * 1000)
    assert "from an earlier run of the server" in Access().token_problem("/ws?token=old")


def test_topics() -> None:
    assert Access().may_see("/anything")
    access = Access(topics=("/camera/*", "/tf"))
    assert access.visible_names(["/camera/image", "/camera", "/tf", "/tf_static", "/secret"]) == [
        "/camera/image",
        "/tf",
    ]
