"""The name of a bridge's node in ROS 2."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, closing

import pytest

from pyros1.ground.errors import Error
from pyros1.master.server import Master
from pyros1.net.master_client import MasterClient
from pyros1.ros2.bridge.own_name import own_name


@pytest.fixture
def masters() -> Iterator[list[Master]]:
    masters = [Master(port=0, bind_host="127.0.0.1") for _ in range(2)]
    for master in masters:
        master.start()
    yield masters
    for master in masters:
        master.stop()


def test_it_is_that_of_the_master(masters: list[Master]) -> None:
    with ExitStack() as stack:
        clients = [stack.enter_context(closing(MasterClient("/test", each.uri))) for each in (masters[0], *masters)]
        check_names(*clients)


def check_names(first: MasterClient, again: MasterClient, other: MasterClient) -> None:
    assert own_name(first) == own_name(again) != own_name(other)
    before = own_name(first)
    first.set_param("/run_id", "7")
    assert own_name(first) == own_name(again) != before
    other.set_param("/run_id", "7")
    assert own_name(other) == own_name(first), "the same master can have several addresses"
    assert own_name(other).startswith("pyros1_bridge_")


def test_a_master_that_does_not_respond(masters: list[Master]) -> None:
    client = MasterClient("/test", masters[0].uri)
    masters[0].stop()
    with closing(client), pytest.raises(Error):
        own_name(client)
