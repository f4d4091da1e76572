"""Liveliness tokens, as others write them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import InvalidNameError, SerializationError
from pyros1.ros2.zenoh.names import HUMBLE_HASH, MAX_DOMAIN, MAX_KEY_LENGTH
from pyros1.ros2.zenoh.qos import Qos
from pyros1.ros2.zenoh.tokens import Entity, Kind, encode_token, gid, parse_token, tokens_of

STRING_HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
ADD_HASH = "RIHS01_e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a"
STRING = f"std_msgs::msg::dds_::String_/{STRING_HASH}"
ADD = f"example_interfaces::srv::dds_::AddTwoInts_/{ADD_HASH}"
ZID = "46f9c9774359144ee64ff1b634522c78"
ROOT = f"@ros2_lv/0/{ZID}"
# Of zenoh-ros2-sdk 0.1.8, made for rmw_zenoh.
TOKENS = {
    f"{ROOT}/0/0/NN/%/%/sdk_talker": Entity(0, ZID, 0, 0, Kind.NODE, "sdk_talker"),
    f"{ROOT}/1/1/NN/%/%robot1%arm/sdk_listener": Entity(0, ZID, 1, 1, Kind.NODE, "sdk_listener", "/robot1/arm"),
    f"{ROOT}/0/0/MP/%/%/sdk_talker/%chatter/{STRING}/::,10:,:,:,,": Entity(
        0, ZID, 0, 0, Kind.PUBLISHER, "sdk_talker", "/", "/", "/chatter", "std_msgs/msg/String", STRING_HASH
    ),
    f"{ROOT}/1/1/MS/%/%robot1%arm/sdk_listener/%back/{STRING}/::,10:,:,:,,": Entity(
        0, ZID, 1, 1, Kind.SUBSCRIBER, "sdk_listener", "/robot1/arm", "/", "/back", "std_msgs/msg/String", STRING_HASH
    ),
    f"{ROOT}/2/2/MP/%/%/sdk_map/%map_name/{STRING}/:1:,1:,:,:,,": Entity(
        0, ZID, 2, 2, Kind.PUBLISHER, "sdk_map", "/", "/", "/map_name", "std_msgs/msg/String", STRING_HASH,
        Qos(transient_local=True, depth=1),
    ),
    f"{ROOT}/3/3/SS/%/%/sdk_server/%add/{ADD}/::,10:,:,:,,": Entity(
        0, ZID, 3, 3, Kind.SERVICE, "sdk_server", "/", "/", "/add", "example_interfaces/srv/AddTwoInts", ADD_HASH
    ),
    f"{ROOT}/4/4/SC/%/%/sdk_client/%ours_add/{ADD}/::,10:,:,:,,": Entity(
        0, ZID, 4, 4, Kind.CLIENT, "sdk_client", "/", "/", "/ours_add", "example_interfaces/srv/AddTwoInts", ADD_HASH
    ),
}  # fmt: skip
# As zenoh-ros2-sdk has understood it.
OURS = (
    f"@ros2_lv/0/3065fc9e59b29f826ebac4167a0cb95/0/1/MP/%/%/pyros1_bridge/%back/{STRING}/1:2:1,10:,:,:,,",
    Entity(
        0, "3065fc9e59b29f826ebac4167a0cb95", 0, 1, Kind.PUBLISHER, "pyros1_bridge",
        topic="/back", type="std_msgs/msg/String", hash=STRING_HASH,
    ),
)  # fmt: skip
PUBLISHER = OURS[1]


@pytest.mark.parametrize("text", TOKENS)
def test_tokens_of_others(text: str) -> None:
    assert parse_token(text) == TOKENS[text]


def test_an_own_token() -> None:
    text, entity = OURS
    assert encode_token(entity) == text
    assert parse_token(text) == entity
    last = (1 << 64) - 1
    assert f"/{last}/{last}/MP/" in encode_token(entity._replace(node_id=last, entity_id=last))


def test_the_own_token_of_a_node_in_a_namespace() -> None:
    node = Entity(7, "a1", 3, 3, Kind.NODE, "driver", "/robot1/arm", "/secure/arm", topic="/ignored")
    assert encode_token(node) == "@ros2_lv/7/a1/3/3/NN/%secure%arm/%robot1%arm/driver"
    assert node.full_node_name == "/robot1/arm/driver"
    assert node._replace(namespace="/").full_node_name == "/driver"


def test_humble() -> None:
    entity = parse_token(f"{ROOT}/1/2/MP/%/%/talker/%chatter/std_msgs::msg::dds_::String_/{HUMBLE_HASH}/::,7:,:,:,,")
    assert entity is not None and entity.hash == HUMBLE_HASH and entity.type == "std_msgs/msg/String"


@pytest.mark.parametrize("text", TOKENS)
def test_parts_that_newer_versions_add(text: str) -> None:
    assert parse_token(text + "/cpu:1/more") == TOKENS[text]


def test_missing_first_slashes() -> None:
    token = f"{ROOT}/1/1/MS/%/robot1/listener/back/{STRING}/::,10:,:,:,,"
    entity = parse_token(token)
    assert entity is not None and (entity.namespace, entity.topic) == ("/robot1", "/back")


@pytest.mark.parametrize(
    ("part", "value"),
    [
        (0, "@ros2"),
        (1, "x"),
        (1, str(MAX_DOMAIN + 1)),
        (2, ""),
        (2, "xyz"),
        (2, "A1"),
        (2, "1" * 33),
        (2, "a1\n"),
        (3, "-1"),
        (3, str(1 << 64)),
        (4, "x"),
        (4, str(1 << 64)),
        (5, "XX"),
        (5, "NODE"),
        (6, ""),
        (6, "%%"),
        (7, ""),
        (7, "%1"),
        (7, "%a%"),
        (8, ""),
        (8, "%a"),
        (8, "1a"),
        (8, "a\n"),
        (9, "%"),
        (9, ""),
        (9, "%a*"),
        (9, "%" + "a" * 247),
        (10, "std_msgs::String"),
        (11, ""),
        (11, "*"),
        (12, ""),
        (12, "1:2"),
        (12, "::,10:,:,:,,".replace("10", "x")),
    ],
)
def test_what_is_not_a_token(part: int, value: str) -> None:
    parts = OURS[0].split("/")
    parts[part] = value
    assert parse_token("/".join(parts)) is None


def test_cut_tokens() -> None:
    parts = OURS[0].split("/")
    for count in range(len(parts)):
        assert parse_token("/".join(parts[:count])) is None


def test_long_tokens() -> None:
    text = OURS[0] + "/"
    assert parse_token(text.ljust(MAX_KEY_LENGTH, "x")) == PUBLISHER
    assert parse_token(text.ljust(MAX_KEY_LENGTH + 1, "x")) is None


@pytest.mark.parametrize(
    "entity",
    [
        PUBLISHER._replace(domain=-1),
        PUBLISHER._replace(zid=""),
        PUBLISHER._replace(zid="x/y"),
        PUBLISHER._replace(node_id=-1),
        PUBLISHER._replace(entity_id=1 << 64),
        PUBLISHER._replace(node_name=""),
        PUBLISHER._replace(node_name="a/b"),
        PUBLISHER._replace(namespace=""),
        PUBLISHER._replace(namespace="/a%b"),
        PUBLISHER._replace(enclave="a"),
        PUBLISHER._replace(topic=""),
        PUBLISHER._replace(topic="/a%b"),
        PUBLISHER._replace(type="std_msgs/String"),
        PUBLISHER._replace(hash=""),
        PUBLISHER._replace(hash="*"),
    ],
)
def test_what_cannot_be_written(entity: Entity) -> None:
    with pytest.raises(InvalidNameError):
        encode_token(entity)


def test_a_profile_that_cannot_be_written() -> None:
    with pytest.raises(SerializationError):
        encode_token(PUBLISHER._replace(qos=Qos(depth=-1)))


def test_all_tokens_of_a_domain() -> None:
    assert tokens_of(42) == "@ros2_lv/42/**"
    with pytest.raises(InvalidNameError):
        tokens_of(-1)


def test_gids() -> None:
    gids = {gid(token) for token in TOKENS}
    assert len(gids) == len(TOKENS) and {len(value) for value in gids} == {16}
    assert gid(OURS[0]) == gid(OURS[0])
    assert len(gid("\ud800")) == 16


WORD = st.text("Ab1_", max_size=8).map(lambda rest: f"_{rest}")
PATH = st.lists(WORD, min_size=1, max_size=3).map(lambda words: "/" + "/".join(words))
NUMBERS = st.integers(0, (1 << 64) - 1)
KINDS = st.sampled_from([kind for kind in Kind if kind is not Kind.NODE])
QOS = st.builds(Qos, st.booleans(), st.booleans(), st.integers(1, 1000), st.booleans())


@given(NUMBERS, NUMBERS, KINDS, WORD, PATH | st.just("/"), PATH | st.just("/"), PATH, QOS)
def test_there_and_back(
    node_id: int, entity_id: int, kind: Kind, node: str, namespace: str, enclave: str, topic: str, qos: Qos
) -> None:
    type_ = "a/srv/B"
    entity = Entity(9, ZID, node_id, entity_id, kind, node, namespace, enclave, topic, type_, HUMBLE_HASH, qos)
    assert parse_token(encode_token(entity)) == entity
    node_entity = Entity(9, ZID, node_id, node_id, Kind.NODE, node, namespace, enclave)
    assert parse_token(encode_token(node_entity)) == node_entity


PIECES = st.sampled_from(["0", "%", "%a", "/", "NN", "MP", "::", STRING, "::,1:,:,:,,", "\ud800", "\x00", "*", ZID])


@given(
    st.text(max_size=1000)
    | st.lists(PIECES, max_size=14).map(lambda pieces: "@ros2_lv/" + "/".join(pieces))
    | st.lists(PIECES, max_size=6).map(lambda pieces: f"{ROOT}/0/0/MP/" + "/".join(pieces))
)
def test_any_text(text: str) -> None:
    entity = parse_token(text)
    assert entity is None or parse_token(encode_token(entity)) == entity
    gid(text)
