"""The types of services on both sides, and how calls are converted."""

from __future__ import annotations

import pytest

from pyros1.ground.errors import Error, MessageError, UnknownTypeError
from pyros1.ros2.pairs.type_pairs import TypePairs
from pyros1.ros2.zenoh.names import HUMBLE_HASH

SET_BOOL = ("std_srvs/srv/SetBool", "RIHS01_abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a")
# As real ROS 2 Kilted has them.
HASHES = dict(
    [
        SET_BOOL,
        ("std_srvs/srv/Empty", "RIHS01_5888399dedec5ccc85ea6451949fd2c9f97bfdf963f9a588821639fcd31b5d19"),
        ("std_srvs/srv/Trigger", "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f"),
        ("nav_msgs/srv/GetPlan", "RIHS01_234f7aff100f5edb8150366601687b027bcdc253db47decb88fff846193fe5e8"),
        ("nav_msgs/srv/SetMap", "RIHS01_5e11a5b2ca53d8ae85b666a019f16c9904ebc787828f1f566c4e048a1ddedfb4"),
        ("sensor_msgs/srv/SetCameraInfo", "RIHS01_a10cca5d33dc637c8d49db50ab288701a3592bb9cd854f2f16a0659613b68984"),
        ("diagnostic_msgs/srv/SelfTest", "RIHS01_df1e4e54a814a16ccc77471e9239618d46818e8d0e3b45ad6f8c34c6e2abfef6"),
    ]
)


@pytest.fixture(scope="module")
def pairs() -> TypePairs:
    return TypePairs()


@pytest.mark.parametrize("name", HASHES)
def test_services_of_standard_packages(pairs: TypePairs, name: str) -> None:
    pair = pairs.service_for_ros2(name, HASHES[name])
    assert (pair.ros1, pair.ros2, pair.hash) == (name.replace("/srv/", "/"), name, HASHES[name])
    assert pairs.service_for_ros1(pair.ros1, pair.md5sum) == pairs.service_for_ros1(pair.ros1, pair.md5sum)
    assert pairs.service_for_ros1(pair.ros1, pair.md5sum).hash == pair.hash


def test_requests_and_responses(pairs: TypePairs) -> None:
    pair = pairs.service_for_ros2(*SET_BOOL)
    assert pair.md5sum == "09fb03525b03e7ea1fd3992bafd87e16"
    assert pair.request.from_cdr(b"\0\1\0\0\1") == b"\1" and pair.request.to_cdr(b"\1") == b"\0\1\0\0\1"
    assert pair.response.to_cdr(b"\1\2\0\0\0ok") == b"\0\1\0\0\1\0\0\0\3\0\0\0ok\0"
    assert pair.response.from_cdr(b"\0\1\0\0\1\0\0\0\3\0\0\0ok\0") == b"\1\2\0\0\0ok"


def test_parts_without_fields_have_a_byte_in_ros2(pairs: TypePairs) -> None:
    pair = pairs.service_for_ros2("std_srvs/srv/Empty", HASHES["std_srvs/srv/Empty"])
    for part in (pair.request, pair.response):
        assert part.to_cdr(b"") == b"\0\1\0\0\0" and part.from_cdr(b"\0\1\0\0\0") == b""


def test_humble_has_no_hashes(pairs: TypePairs) -> None:
    pair = pairs.service_for_ros2("std_srvs/srv/SetBool", HUMBLE_HASH)
    assert (pair.ros1, pair.hash) == ("std_srvs/SetBool", HUMBLE_HASH)


def test_services_that_are_not_known_or_not_the_same(pairs: TypePairs) -> None:
    for _ in range(2):  # the second time from memory
        with pytest.raises(Error, match="strange_interfaces/Add"):
            pairs.service_for_ros2("strange_interfaces/srv/Add", HASHES["std_srvs/srv/Empty"])
        with pytest.raises(UnknownTypeError, match="another definition of std_srvs/srv/SetBool"):
            pairs.service_for_ros2("std_srvs/srv/SetBool", HASHES["std_srvs/srv/Empty"])
        with pytest.raises(MessageError, match="differs from the provider's"):
            pairs.service_for_ros1("std_srvs/SetBool", "0" * 32)
