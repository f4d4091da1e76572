"""Names of types, and the keys of data, as rmw_zenoh writes them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import InvalidNameError
from pyros1.ros2.zenoh.names import (
    ANY_HASH,
    HUMBLE_HASH,
    MAX_DOMAIN,
    MAX_KEY_LENGTH,
    DataKey,
    data_key,
    dds_type,
    is_full_name,
    parse_data_key,
    read_number,
    type_of_dds,
)
from pyros1.ros2_types.model import is_type_name

STRING_HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
ADD_HASH = "RIHS01_e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a"
CHATTER = DataKey(0, "/chatter", "std_msgs/msg/String", STRING_HASH)
# The first two are from zenoh-ros2-sdk 0.1.8, made for rmw_zenoh.
KEYS = {
    f"0/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}": CHATTER,
    f"0/add/example_interfaces::srv::dds_::AddTwoInts_/{ADD_HASH}": DataKey(
        0, "/add", "example_interfaces/srv/AddTwoInts", ADD_HASH
    ),
    f"232/robot_1/odom/nav_msgs::msg::dds_::Odometry_/{HUMBLE_HASH}": DataKey(
        232, "/robot_1/odom", "nav_msgs/msg/Odometry", HUMBLE_HASH
    ),
    "7/fib/_action/send_goal/example_interfaces::action::dds_::Fibonacci_SendGoal_/RIHS01_0": DataKey(
        7, "/fib/_action/send_goal", "example_interfaces/action/Fibonacci_SendGoal", "RIHS01_0"
    ),
}
NOT_KEYS = [
    "",
    "/",
    "0",
    "0/chatter",
    f"0/std_msgs::msg::dds_::String_/{STRING_HASH}",
    f"0//chatter/std_msgs::msg::dds_::String_/{STRING_HASH}",
    f"0/chatter//std_msgs::msg::dds_::String_/{STRING_HASH}",
    f"/0/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}",
    f"-1/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}",
    f"1_0/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}",
    f"\u0661/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}",
    f"{MAX_DOMAIN + 1}/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}",
    f"0/1chatter/std_msgs::msg::dds_::String_/{STRING_HASH}",
    f"0/ch*tter/std_msgs::msg::dds_::String_/{STRING_HASH}",
    f"0/chatter/std_msgs::msg::dds_::String/{STRING_HASH}",
    f"0/chatter/std_msgs::dds_::String_/{STRING_HASH}",
    f"0/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}/_buf_cpu",
    f"0/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}\n",
    "0/chatter/std_msgs::msg::dds_::String_/",
    "0/chatter/std_msgs::msg::dds_::String_/*",
    "0/chatter/std_msgs::msg::dds_::String_/" + "a" * MAX_KEY_LENGTH,
]


@pytest.mark.parametrize("text", KEYS)
def test_keys(text: str) -> None:
    assert parse_data_key(text) == KEYS[text]
    assert data_key(KEYS[text]) == text


@pytest.mark.parametrize("text", NOT_KEYS)
def test_what_is_not_a_key(text: str) -> None:
    assert parse_data_key(text) is None


def test_a_subscriber_may_take_any_hash() -> None:
    assert data_key(CHATTER._replace(hash=ANY_HASH)) == "0/chatter/std_msgs::msg::dds_::String_/*"


@pytest.mark.parametrize(
    "key",
    [
        CHATTER._replace(domain=-1),
        CHATTER._replace(domain=MAX_DOMAIN + 1),
        CHATTER._replace(name="chatter"),
        CHATTER._replace(name="/"),
        CHATTER._replace(name="/**"),
        CHATTER._replace(name="/" + "a" * 247),
        CHATTER._replace(type="std_msgs/String"),
        CHATTER._replace(type=""),
        CHATTER._replace(hash=""),
        CHATTER._replace(hash="a/b"),
        CHATTER._replace(hash="**"),
    ],
)
def test_keys_that_cannot_be_written(key: DataKey) -> None:
    with pytest.raises(InvalidNameError):
        data_key(key)


@pytest.mark.parametrize("name", ["/a", "/_a", "/a/b_1/C", "/a__b", "/" + "a" * 246])
def test_legal_names(name: str) -> None:
    assert is_full_name(name)


@pytest.mark.parametrize("name", ["", "/", "a", "/a/", "//a", "/a//b", "/1", "/a/2b", "/a b", "/\u00e4", "/a\n", "/~a"])
def test_illegal_names(name: str) -> None:
    assert not is_full_name(name)


def test_type_names() -> None:
    assert dds_type("std_msgs/msg/String") == "std_msgs::msg::dds_::String_"
    assert dds_type("std_srvs/srv/SetBool") == "std_srvs::srv::dds_::SetBool_"
    assert type_of_dds("a::action::dds_::Fib_FeedbackMessage_") == "a/action/Fib_FeedbackMessage"
    assert is_type_name("std_msgs/msg/String") and not is_type_name("std_msgs/String")
    assert not is_type_name("std_msgs/idl/String") and not is_type_name("std_msgs/msg/String\n")


@pytest.mark.parametrize(
    "name", ["std_msgs/msg/String", "::msg::dds_::String_", "a::msg::dds_::B_\n", "a::msg::x_::B_"]
)
def test_what_is_not_a_dds_type(name: str) -> None:
    assert type_of_dds(name) is None


def test_numbers() -> None:
    assert read_number("0", 10) == 0 and read_number("10", 10) == 10
    for text in ("", "11", "+1", " 1", "1_0", "0x1", "1\n", "\u0661", "9" * 5000):
        assert read_number(text, 10) is None


WORD = st.text("Ab1_", max_size=8).map(lambda rest: f"a{rest}")


@given(
    st.integers(0, MAX_DOMAIN),
    st.lists(WORD, min_size=1, max_size=5),
    st.tuples(WORD, st.sampled_from(["msg", "srv", "action"]), WORD),
    st.sampled_from([HUMBLE_HASH, STRING_HASH]),
)
def test_there_and_back(domain: int, name: list[str], type_name: tuple[str, str, str], hash_: str) -> None:
    key = DataKey(domain, "/" + "/".join(name), "/".join(type_name), hash_)
    assert parse_data_key(data_key(key)) == key


PIECES = st.sampled_from(["0", "chatter", "/", "::", "dds_", "_", "msg", "String_", "%", "*", ":1,2", "\ud800", "\x00"])


@given(st.text(max_size=1000) | st.lists(PIECES, max_size=40).map("".join))
def test_any_text(text: str) -> None:
    key = parse_data_key(text)
    assert key is None or data_key(key).split("/")[1:] == text.split("/")[1:]
    for function in (type_of_dds, is_full_name, is_type_name):
        function(text)
    try:
        dds_type(text)
    except InvalidNameError:
        pass
    else:
        assert is_type_name(text)
