"""What must hold between pyros1 and a stock peer, once for every direction; test_<direction>_<peer>.py name the peer.

Fixtures: ``ours`` and ``peer`` are running peer programs under ``master``, ``topic`` is a fresh name.
"""

from __future__ import annotations

import struct

import pytest
from harness import Master, Peer, until
from samples import PARAMETERS, TYPES, show, unpack_log

FLOAT, TEXT, JOINTS, IMAGE = "std_msgs/Float64", "std_msgs/String", "sensor_msgs/JointState", "sensor_msgs/Image"

# How each implementation counts header.seq (T22).
FIRST_SEQ = {"rospy": 1, "roscpp": 0, "pyros1": 1}


class Direction:
    """A test class for one stock peer."""

    kind = "rospy"


def without_seq(body: str) -> str:
    """A message that starts with a Header, without the number that each publisher writes itself."""
    return body[8:]


def seq(body: str) -> int:
    """header.seq of a serialized message that starts with a Header."""
    return int(struct.unpack("<I", bytes.fromhex(body[:8]))[0])


class Streams(Direction):
    """Messages from one side to the other; the subclasses say which side publishes."""

    def sides(self, ours: Peer, peer: Peer) -> tuple[Peer, Peer]:
        """Publisher and subscriber."""
        raise NotImplementedError

    def connect(self, ours: Peer, peer: Peer, topic: str, type_name: str, **options: int) -> tuple[Peer, Peer]:
        source, sink = self.sides(ours, peer)
        source.advertise(topic, type_name, **options)
        sink.subscribe(topic, type_name, queue_size=0)
        source.linked(topic)
        sink.linked(topic)
        return source, sink

    def test_every_message_arrives_once_and_in_order(self, ours: Peer, peer: Peer, topic: str) -> None:
        source, sink = self.connect(ours, peer, topic, FLOAT, queue_size=1000)
        source.ask("burst", topic, 0, 500, event=f"burst {topic}")
        numbers = [struct.unpack("<d", bytes.fromhex(sink.received(topic)))[0] for _ in range(500)]
        assert numbers == [seed + 0.1 for seed in range(500)]
        assert not sink.unread(f"^got {topic} ")

    def test_subscriber_first_then_publisher(self, ours: Peer, peer: Peer, topic: str) -> None:
        source, sink = self.sides(ours, peer)
        sink.subscribe(topic, TEXT)
        source.advertise(topic, TEXT)
        source.linked(topic)
        sent = source.publish(topic)
        assert sink.received(topic) == sent

    def test_subscriber_leaves_and_comes_back(self, ours: Peer, peer: Peer, topic: str) -> None:
        source, sink = self.connect(ours, peer, topic, TEXT)
        sink.ask("unsub", topic, event=f"unsubscribed {topic}")
        source.linked(topic, 0)
        sink.subscribe(topic, TEXT)
        source.linked(topic, 1)
        sent = source.publish(topic, 2)
        assert sink.received(topic) == sent

    def test_publisher_leaves_and_comes_back(self, ours: Peer, peer: Peer, topic: str) -> None:
        source, sink = self.connect(ours, peer, topic, TEXT)
        source.ask("unpub", topic, event=f"unadvertised {topic}")
        sink.linked(topic, 0)
        source.advertise(topic, TEXT)
        source.linked(topic)
        sent = source.publish(topic, 3)
        assert sink.received(topic) == sent

    def test_seq_and_connection_header(self, ours: Peer, peer: Peer, topic: str) -> None:
        """T07, T21, T22: what the publisher says of itself, and header.seq, reach the callback."""
        source, sink = self.connect(ours, peer, topic, JOINTS)
        source.publish(topic, 40)
        source.publish(topic, 41)
        assert seq(sink.received(topic)) == FIRST_SEQ[source.kind]
        assert seq(sink.received(topic)) == FIRST_SEQ[source.kind] + 1
        header = sink.header(topic)
        assert header["callerid"] == source.name
        assert header["type"] == JOINTS
        assert header["md5sum"] == "3066dcd76a6cfaef579bd0f34173e9fd"
        assert header["latching"] == "0"
        assert header["topic"] == topic
        assert header["message_definition"]


class Subscribing(Streams):
    """The stock peer publishes, pyros1 subscribes."""

    def sides(self, ours: Peer, peer: Peer) -> tuple[Peer, Peer]:
        return peer, ours


class Publishing(Streams):
    """pyros1 publishes, the stock peer subscribes."""

    def sides(self, ours: Peer, peer: Peer) -> tuple[Peer, Peer]:
        return ours, peer


class Latching(Direction):
    """A latched publisher gives its last message to whoever comes later (T18, T19), in both directions."""

    def test_late_subscriber_gets_the_newest(self, ours: Peer, peer: Peer, topic: str) -> None:
        for source, sink, name in ((ours, peer, topic + "/a"), (peer, ours, topic + "/b")):
            source.advertise(name, TEXT, latch=True)
            source.publish(name, 1)
            sent = source.publish(name, 2)
            sink.subscribe(name, TEXT)
            assert sink.received(name) == sent
            assert sink.header(name)["latching"] == "1"
            later = source.publish(name, 3)
            assert sink.received(name) == later

    def test_every_subscription_gets_it(self, ours: Peer, peer: Peer, topic: str) -> None:
        for source, sink, name in ((ours, peer, topic + "/a"), (peer, ours, topic + "/b")):
            source.advertise(name, JOINTS, latch=True)
            sent = source.publish(name, 7)
            for _ in range(2):
                sink.subscribe(name, JOINTS)
                assert without_seq(sink.received(name)) == without_seq(sent)
                sink.ask("unsub", name, event=f"unsubscribed {name}")
                source.linked(name, 0)

    def test_one_message_from_each_publisher(self, ours: Peer, peer: Peer, launcher: Master, topic: str) -> None:
        """T20."""
        third = launcher.ready_peer("rospy", "third_latcher")
        sent = set()
        for seed, source in enumerate((ours, peer, third)):
            source.advertise(topic, TEXT, latch=True)
            sent.add(source.publish(topic, seed))
        sink = launcher.ready_peer(ours.kind, "latch_listener")
        sink.subscribe(topic, TEXT)
        assert {sink.received(topic) for _ in range(3)} == sent
        other = launcher.ready_peer(peer.kind, "other_latch_listener")
        other.subscribe(topic, TEXT)
        assert {other.received(topic) for _ in range(3)} == sent


class Types(Direction):
    """Every kind of field, in both directions: bytes are equal, so each side understood what the other wrote."""

    def test_peers_know_the_same_types(self, ours: Peer, peer: Peer) -> None:
        assert sorted(TYPES) == ours.ask("types").split() == peer.ask("types").split()

    @pytest.mark.parametrize("type_name", TYPES)
    def test_message(self, ours: Peer, peer: Peer, topic: str, type_name: str) -> None:
        has_header = type_name not in ("std_msgs/Header",) and type_name.split("/")[1] in WITH_HEADER
        there, back = topic + "/there", topic + "/back"
        for source, sink, name in ((peer, ours, there), (ours, peer, back)):
            source.advertise(name, type_name)
            sink.subscribe(name, type_name)
        for source, sink, name, seed in ((peer, ours, there, 5), (ours, peer, back, 6)):
            source.linked(name)
            sink.linked(name)
            source.publish(name, seed)
            got = sink.received(name)
            expected = sink.ask("sample", type_name, seed, event=f"sample {type_name}")
            if has_header:
                got, expected = without_seq(got), without_seq(expected)
            assert got == expected


WITH_HEADER = {
    "JointState", "Imu", "CameraInfo", "LaserScan", "PointCloud2", "Image", "Odometry", "DiagnosticArray", "Marker",
    "JointTrajectory", "Log",
}  # fmt: skip


class Mismatch(Direction):
    """Both sides refuse a type that differs, and say why (T08, T11, T27, T33)."""

    def test_wrong_publisher_is_refused(self, ours: Peer, peer: Peer, topic: str) -> None:
        """Our publisher answers the stock subscriber with an error and reports it; the right one gets its messages."""
        ours.advertise(topic, FLOAT)
        peer.subscribe(topic, TEXT)
        said = ours.wait_line(f"(?=.*{topic})(?=.*{peer.name}).*(types do not match|datatype/md5sum)")
        assert TEXT in said.string and FLOAT in said.string
        ours.publish(topic)
        ours.linked(topic, 0)
        assert not peer.unread(f"^got {topic}")

    def test_wrong_subscriber_is_refused(self, ours: Peer, peer: Peer, topic: str) -> None:
        """The stock publisher reports our subscriber, and our side passes its reason on."""
        peer.advertise(topic, FLOAT)
        ours.subscribe(topic, TEXT)
        said = peer.wait_line(f"(?=.*{topic})(?=.*{ours.name}).*(types do not match|datatype/md5sum)")
        assert TEXT in said.string and FLOAT in said.string
        peer.linked(topic, 0)
        if ours.kind == "pyros1":
            reason = ours.wait_line(f"(?=.*{topic})(?=.*(types do not match|datatype/md5sum))").string
            assert TEXT in reason and FLOAT in reason

    def test_wrong_client_is_refused(self, ours: Peer, peer: Peer, topic: str) -> None:
        ours.serve(topic, "std_srvs/SetBool")
        peer.available(topic)
        error = peer.call_failing(topic, "std_srvs/Trigger")
        if peer.kind == "rospy":
            assert "md5sum" in error
        ours.wait_line(f"(?=.*({peer.name}|{topic})).*md5sum")
        assert not ours.unread(f"^served {topic}")

    def test_wrong_server_is_refused(self, ours: Peer, peer: Peer, topic: str) -> None:
        peer.serve(topic, "std_srvs/SetBool")
        ours.available(topic)
        error = ours.call_failing(topic, "std_srvs/Trigger")
        if ours.kind == "pyros1":
            assert topic in error and "md5sum" in error
        assert not peer.unread(f"^served {topic}")


class Large(Direction):
    """Images of 1 MB and 6.2 MB arrive whole, one after the other, in both directions."""

    @pytest.mark.parametrize("size", [1_000_000, 6_220_800])
    def test_images(self, ours: Peer, peer: Peer, topic: str, size: int) -> None:
        there, back = topic + "/there", topic + "/back"
        for source, sink, name in ((peer, ours, there), (ours, peer, back)):
            source.advertise(name, IMAGE, queue_size=10)
            sink.subscribe(name, IMAGE, queue_size=0)
            source.linked(name)
            sink.linked(name)
            for _ in range(5):
                source.tell("send", name, size)
            got = [sink.received(name) for _ in range(5)]
            assert all(body.startswith(f"#{size + 48}:") for body in got), got
            # each image has its own header.seq, and so its own checksum
            assert len(set(got)) == 5
            sent = [source.event("sent", name) for _ in range(5)]
            # roscpp writes seq into its copy for the wire only, and pyros1 into the message when it is its turn, which
            # may be after publish() has returned.
            if source.kind == "rospy":
                assert got == sent
            elif source.kind == "pyros1":
                assert set(got) & set(sent)


class Serving(Direction):
    """pyros1 serves, the stock peer calls."""

    def sides(self, ours: Peer, peer: Peer) -> tuple[Peer, Peer]:
        """Server and client."""
        return ours, peer

    @pytest.mark.parametrize("persistent", [False, True], ids=["single", "persistent"])
    @pytest.mark.parametrize(
        "type_name", ["std_srvs/Empty", "std_srvs/Trigger", "std_srvs/SetBool", "nav_msgs/GetPlan"]
    )
    def test_calls(self, ours: Peer, peer: Peer, topic: str, type_name: str, persistent: bool) -> None:
        server, client = self.sides(ours, peer)
        server.serve(topic, type_name)
        client.available(topic)
        for seed in (1, 2, 3):
            request, response = client.call(topic, type_name, seed, persistent)
            assert server.event("served", topic) == request
            assert (response == "-") == (type_name == "std_srvs/Empty")
            if type_name == "nav_msgs/GetPlan":
                assert request[: len(request) // 4] in response
        if persistent:
            client.ask("hangup", topic, event=f"hung {topic}")

    @pytest.mark.parametrize("mode", ["refuse", "throw"])
    def test_failing_handler(self, ours: Peer, peer: Peer, topic: str, mode: str) -> None:
        """T26-T28: the caller gets an error, the server goes on."""
        server, client = self.sides(ours, peer)
        server.serve(topic, "std_srvs/SetBool", mode)
        client.available(topic)
        for _ in range(2):
            error = client.call_failing(topic, "std_srvs/SetBool")
            server.event("served", topic)
            if client.kind != "roscpp" and not (server.kind == "roscpp" and mode == "refuse"):
                assert "no luck" in error

    def test_failing_handler_leaves_a_persistent_client_connected(self, ours: Peer, peer: Peer, topic: str) -> None:
        server, client = self.sides(ours, peer)
        server.serve(topic, "std_srvs/SetBool", "refuse")
        client.available(topic)
        for _ in range(2):
            client.call_failing(topic, "std_srvs/SetBool", persistent=True)
            server.event("served", topic)

    def test_server_leaves_and_comes_back(self, ours: Peer, peer: Peer, topic: str) -> None:
        server, client = self.sides(ours, peer)
        server.serve(topic, "std_srvs/SetBool")
        client.call(topic, "std_srvs/SetBool")
        server.ask("unserve", topic, event=f"unserved {topic}")
        error = client.call_failing(topic, "std_srvs/SetBool")
        if client.kind != "roscpp":
            assert topic in error
        server.serve(topic, "std_srvs/SetBool")
        client.available(topic)
        client.call(topic, "std_srvs/SetBool")

    @pytest.mark.parametrize("persistent", [False, True], ids=["single", "persistent"])
    def test_server_dies_during_the_call(self, ours: Peer, peer: Peer, launcher: Master, topic: str, persistent: bool):
        server, client = self.sides(ours, peer)
        mortal = launcher.ready_peer(server.kind, "mortal_server")
        mortal.serve(topic, "std_srvs/SetBool", "die")
        client.available(topic)
        client.call_failing(topic, "std_srvs/SetBool", persistent=persistent)
        assert mortal.wait() == 9


class Calling(Serving):
    """The stock peer serves, pyros1 calls."""

    def sides(self, ours: Peer, peer: Peer) -> tuple[Peer, Peer]:
        return peer, ours


class Parameters(Direction):
    """Values of every kind, written by one side and read by the other; searching; cached values (S09, M46-M54)."""

    @pytest.mark.parametrize("sample", PARAMETERS)
    def test_value(self, ours: Peer, peer: Peer, topic: str, sample: str) -> None:
        for writer, reader, key in ((ours, peer, topic + "/a"), (peer, ours, topic + "/b")):
            writer.ask("setparam", key, sample, event=f"set {key}")
            for each in (reader, writer):
                assert each.ask("getparam", key, event=f"getparam {key}") == show(PARAMETERS[sample])

    def test_unset_has_delete(self, ours: Peer, peer: Peer, topic: str) -> None:
        for writer, reader in ((ours, peer), (peer, ours)):
            assert reader.ask("getparam", topic) == "unset"
            assert reader.ask("hasparam", topic) == "0"
            assert writer.ask("delparam", topic) == "0"
            writer.ask("setparam", topic, "int", event=f"set {topic}")
            assert reader.ask("hasparam", topic) == "1"
            assert writer.ask("delparam", topic) == "1"
            assert reader.ask("hasparam", topic) == "0"

    def test_subtree_and_relative_names(self, ours: Peer, peer: Peer, topic: str) -> None:
        for writer, reader in ((ours, peer), (peer, ours)):
            writer.ask("setparam", topic, "dict", event=f"set {topic}")
            writer.ask("setparam", topic + "/b/e", "true", event=f"set {topic}/b/e")
            key = topic.removeprefix("/")
            assert reader.ask("getparam", key + "/b/e") == "true"
            assert '"e": true' in reader.ask("getparam", key)
            writer.ask("delparam", topic, event=f"delparam {topic} 1")

    def test_search(self, ours: Peer, peer: Peer, topic: str) -> None:
        name = topic.rsplit("/", 1)[1]
        for each in (ours, peer):
            assert each.ask("searchparam", name) == "none"
        peer.ask("setparam", "/" + name, "int", event=f"set /{name}")
        for each in (ours, peer):
            assert each.ask("searchparam", name) == "/" + name
        # a private parameter is nearer than a global one
        ours.ask("setparam", f"{ours.name}/{name}", "int", event=f"set {ours.name}/{name}")
        assert ours.ask("searchparam", name) == f"{ours.name}/{name}"
        assert peer.ask("searchparam", name) == "/" + name

    def test_cached_value_follows_the_other_side(self, ours: Peer, peer: Peer, topic: str) -> None:
        for writer, reader, key in ((ours, peer, topic + "/a"), (peer, ours, topic + "/b")):
            writer.ask("setparam", key, "int", event=f"set {key}")
            assert reader.ask("cachedparam", key) == "42"
            writer.ask("setparam", key, "text", event=f"set {key}")
            self.becomes(reader, key, show(PARAMETERS["text"]))

    def becomes(self, reader: Peer, key: str, shown: str) -> None:
        """Updates of cached parameters come by themselves, some time after the writer's call returned."""
        until(lambda: reader.ask("cachedparam", key) == shown, f"the cached {key} becomes {shown}")


class Logging(Direction):
    """/rosout: what one side logs reaches the other, level, node and text."""

    @pytest.mark.parametrize("level", ["info", "warn", "error", "fatal"])
    def test_rosout(self, ours: Peer, peer: Peer, master: Master, topic: str, level: str) -> None:
        for writer, reader in ((ours, peer), (peer, ours)):
            reader.subscribe("/rosout", "rosgraph_msgs/Log")
            until(lambda: self.linked(master, writer, reader), "the subscriber of /rosout is connected")  # noqa: B023
            text = f"{topic} Grüße {level}"
            writer.ask("log", level, text, event=f"logged {level}")
            while True:  # other nodes log too; received() has the deadline
                number, name, message = unpack_log(reader.received("/rosout"))
                if name == writer.name and message == text:
                    break
            assert number == LEVELS[level]
            reader.ask("unsub", "/rosout", event="unsubscribed /rosout")

    def linked(self, master: Master, writer: Peer, reader: Peer) -> bool:
        links = master.node(writer.name, "getBusInfo")[2]
        return any(link[4] == "/rosout" and link[1] == reader.name for link in links)


LEVELS = {"info": 2, "warn": 4, "error": 8, "fatal": 16}
