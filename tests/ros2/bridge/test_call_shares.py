"""How many calls each client may have in progress."""

from __future__ import annotations

from pyros1.ros2.bridge.call_shares import CallShares


def number_of_calls(shares: CallShares, client: bytes) -> int:
    """Let a client make as many calls as it may."""
    number = 0
    while shares.begin(client):
        number += 1
    return number


def test_one_client_leaves_room_for_others() -> None:
    shares = CallShares(16)
    assert [number_of_calls(shares, client) for client in (b"a", b"b", b"c", b"d", b"e", b"f")] == [8, 4, 2, 1, 1, 0]


def test_calls_that_have_ended_do_not_count() -> None:
    shares = CallShares(4)
    assert number_of_calls(shares, b"a") == 2
    shares.end(b"a")
    assert number_of_calls(shares, b"b") == 2 and number_of_calls(shares, b"a") == 0
    for client in (b"a", b"b", b"b"):
        shares.end(client)
    assert number_of_calls(shares, b"c") == 2


def test_a_single_call() -> None:
    shares = CallShares(1)
    assert shares.begin(b"a") and not shares.begin(b"b")
