"""Two and three masters with bridges over eclipse-zenoh: what nodes at one site get from those at another.

Feature: topics between masters, with types that are installed nowhere else -- `pyros1 bridge`
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from itertools import count
from typing import Any

import pytest

from pyros1.bridge.transport.sender import Sender
from pyros1.ground.errors import NodeError
from pyros1.master.server import Master
from pyros1.msgs import AnyMsg, from_definition
from pyros1.net.hosts import parse_uri
from pyros1.node import Node

from .conftest import QueuedSubscriber, RunningSite, subscriptions, wait_for_subscribers, wait_until

MakeSite = Callable[..., RunningSite]
EVERYTHING = "{send: ['/**'], take: ['*:**', '/**']}"


@pytest.fixture
def pair(make_site: MakeSite, endpoint: str) -> tuple[RunningSite, RunningSite]:
    """A base that listens, and a robot that dials it; they exchange everything."""
    base = make_site("base", EVERYTHING, (), (endpoint,))
    return make_site("red", EVERYTHING, (endpoint,)), base


def test_a_node_that_has_ended_before_its_bridge_begins(make_site: MakeSite, endpoint: str) -> None:
    from pyros1.bridge.runner import Bridge
    from pyros1.bridge.transport.zenoh_link import ZenohLink

    site = make_site("base", EVERYTHING, (), (endpoint,))
    node = site.make_node("interrupted")
    node.shutdown()
    links: list[ZenohLink] = []

    def make_link(receive: Any) -> ZenohLink:
        links.append(ZenohLink("red", receive, (), ("tcp/127.0.0.1:0",)))
        return links[0]

    with pytest.raises(NodeError):
        Bridge(node, site.rules, make_link)
    assert links[0].is_closing


@pytest.mark.slow
def test_topics_go_both_ways(pair: tuple[RunningSite, RunningSite]) -> None:
    for source, target in (pair, pair[::-1]):
        publisher: Any = source.node.advertise("/text", "std_msgs/String")
        topic = f"/{source.name}/text"
        target.has_topic(topic)
        subscriber = QueuedSubscriber(target.node, topic)
        wait_for_subscribers(publisher)
        publisher.publish("hello")
        subscriber.receives("hello")
        assert target.topics()[topic] == "std_msgs/String"


def test_only_sites_that_are_there_have_a_place_of_their_own_to_wait(pair: tuple[RunningSite, RunningSite]) -> None:
    """See `tests/bridge/transport/test_inbox.py`."""
    red, base = pair
    wait_until(lambda: red.bridge.inbox.known == {"base"}, "red knows the base")
    wait_until(lambda: base.bridge.inbox.known == {"red"}, "the base knows red")


@pytest.mark.slow
def test_nothing_is_subscribed_to_that_nobody_wants(pair: tuple[RunningSite, RunningSite]) -> None:
    red, base = pair
    publisher: Any = red.node.advertise("/text", "std_msgs/String")
    base.has_topic("/red/text")
    assert subscriptions(publisher) == 0
    subscriber = QueuedSubscriber(base.node, "/red/text")
    wait_for_subscribers(publisher)
    subscriber.subscriber.unregister()
    wait_until(lambda: subscriptions(publisher) == 0, "the bridge unsubscribes")
    publisher.unregister()
    wait_until(lambda: "/red/text" not in base.topics(), "the topic is withdrawn")


@pytest.mark.slow
def test_the_original_publishers_are_in_the_connections_header(pair: tuple[RunningSite, RunningSite]) -> None:
    red, base = pair
    first: Any = red.make_node("first").advertise("/text", "std_msgs/String", latch=True)
    first.publish("hello")
    base.has_topic("/red/text")
    header = QueuedSubscriber(base.node, "/red/text").get()._connection_header
    assert (header["callerid"], header["origin"]) == ("/bridge_base", "red:/first")
    second: Any = red.make_node("second").advertise("/text", "std_msgs/String", latch=True)
    second.publish("hello")
    numbers = count()

    def late_origin() -> str:
        node = base.make_node(f"late{next(numbers)}")
        return str(QueuedSubscriber(node, "/red/text").get()._connection_header["origin"])

    wait_until(lambda: late_origin() == "red:/first red:/second", "who subscribes later sees both")
    received = {entry["local"]: entry["publishers"] for entry in json.loads(base.bridge.status())["received"]}
    assert received["/red/text"] == ["/first", "/second"]
    for publisher in (first, second):
        publisher.unregister()
    wait_until(lambda: "/red/text" not in base.topics(), "the topic is withdrawn")


def test_types_that_are_installed_nowhere(pair: tuple[RunningSite, RunningSite]) -> None:
    red, base = pair
    definition = "float64 strange\nstring words\n"
    cls: Any = from_definition("nowhere_msgs/Strange", definition)
    publisher: Any = red.node.advertise("/strange", cls, latch=True)
    publisher.publish(1.5, "words")
    base.has_topic("/red/strange")
    subscriber = QueuedSubscriber(base.node, "/red/strange", AnyMsg)  # type: ignore[arg-type]
    header = subscriber.get()._connection_header
    assert header["type"] == "nowhere_msgs/Strange" and header["md5sum"] == cls._md5sum
    assert header["message_definition"] == definition


def test_latched_messages_come_to_who_comes_later(pair: tuple[RunningSite, RunningSite]) -> None:
    red, base = pair
    for name in ("left", "right"):
        publisher: Any = red.make_node(name).advertise("/tf_static", "std_msgs/String", latch=True)
        publisher.publish(name)
    base.has_topic("/red/tf_static")
    for _ in range(2):
        subscriber = QueuedSubscriber(base.make_node(f"listener{_}"), "/red/tf_static")
        assert {subscriber.get().data, subscriber.get().data} == {"left", "right"}


def test_a_latched_message_goes_with_its_publisher(pair: tuple[RunningSite, RunningSite]) -> None:
    red, base = pair
    nodes: list[Node] = [red.make_node(name) for name in ("left", "right")]
    publishers: list[Any] = [node.advertise("/map", "std_msgs/String", latch=True) for node in nodes]
    for publisher in publishers:
        publisher.publish("first")
    base.has_topic("/red/map")
    subscriber = QueuedSubscriber(base.node, "/red/map")
    assert [subscriber.get().data, subscriber.get().data] == ["first", "first"]
    nodes[0].shutdown()
    wait_until(lambda: _sent(red, "/map")["publishers"] == ["/right"], "the bridge notes that left is gone")
    publishers[1].publish("second")
    subscriber.receives("second")
    assert (
        QueuedSubscriber(base.make_node("late"), "/red/map").get().data == "second"
    )  # and not that of left, which was older


@pytest.mark.slow
def test_a_publisher_that_latches_comes_and_goes_without_breaking_connections(
    pair: tuple[RunningSite, RunningSite],
) -> None:
    red, base = pair
    plain: Any = red.node.advertise("/state", "std_msgs/String")
    base.has_topic("/red/state")
    subscriber = QueuedSubscriber(base.node, "/red/state")
    wait_for_subscribers(plain)
    plain.publish("plain")
    subscriber.receives("plain")
    link = subscriber.subscriber.links[0]
    latching = red.make_node("latching")
    publisher: Any = latching.advertise("/state", "std_msgs/String", latch=True)
    publisher.publish("latched")
    subscriber.receives("latched")
    late = QueuedSubscriber(base.make_node("late"), "/red/state")
    late.receives("latched")
    plain.publish("plain again")
    late.receives("plain again")
    latching.shutdown()
    wait_until(lambda: _sent(red, "/state")["publishers"] == [red.node.name], "the bridge notes that it is gone")
    plain.publish("the last")
    subscriber.receives("the last")
    assert any(gets_first(base, plain, number) for number in range(20)), "nothing is latched any more"
    assert link in subscriber.subscriber.links, "the first subscriber is still connected"


def gets_first(base: RunningSite, publisher: Any, number: int) -> bool:
    """Return whether the first message that a new subscriber gets is one that is published after it has connected."""
    subscriber = QueuedSubscriber(base.make_node(f"latest{number}"), "/red/state")
    wait_until(lambda: subscriber.subscriber.num_connections >= 1, "it is connected")
    publisher.publish(f"fresh {number}")
    return bool(subscriber.get().data == f"fresh {number}")


def _sent(site: RunningSite, local: str) -> Any:
    """Return what the status says of a topic that is sent."""
    return next(entry for entry in json.loads(site.bridge.status())["sent"] if entry["local"] == local)


def _received(site: RunningSite, local: str) -> Any:
    return next(entry for entry in json.loads(site.bridge.status())["received"] if entry["local"] == local)


def test_commands_go_into_a_robots_names(make_site: MakeSite, endpoint: str) -> None:
    base = make_site("base", "{send: ['red:/cmd_vel']}", (), (endpoint,))
    red = make_site("red", "{take: [/cmd_vel]}", (endpoint,))
    publisher: Any = base.node.advertise("/red/cmd_vel", "geometry_msgs/Twist")
    red.has_topic("/cmd_vel")
    subscriber = QueuedSubscriber(red.node, "/cmd_vel", "geometry_msgs/Twist")
    wait_for_subscribers(publisher)
    publisher.publish(_twist(0.5))
    assert subscriber.get().linear.x == 0.5


def _twist(speed: float) -> Any:
    from pyros1.msgs.geometry_msgs.msg import Twist, Vector3

    return Twist(linear=Vector3(speed, 0.0, 0.0))


def test_a_site_named_like_a_namespace_here_cannot_command_its_nodes(make_site: MakeSite, endpoint: str) -> None:
    """The base sends nothing, and the driver of its arm only subscribes."""
    base = make_site("base", "take: ['*:**']", (), (endpoint,))
    driver = QueuedSubscriber(base.make_node("driver"), "/arm/goal")
    arm, red = (make_site(name, "send: ['/**']", (endpoint,)) for name in ("arm", "red"))
    for site in (arm, red):
        site.node.advertise("/goal", "std_msgs/String", latch=True).publish(site.name)
    base.has_topic("/red/goal")
    told = "nodes here subscribe to /arm/goal: if site arm may publish there too, name it with --sites"

    def states() -> dict[str, str]:
        received = json.loads(base.bridge.status())["received"]
        return {each["topic"]: each["state"] for each in received if each["topic"].endswith("/goal")}

    wait_until(lambda: states().get("arm:/goal") == told, "the arm's topics are refused")
    listener = QueuedSubscriber(base.node, "/red/goal")
    listener.receives("red")
    assert "/arm/goal" not in base.topics() and driver.is_silent()
    assert states() == {"arm:/goal": told, "red:/goal": "subscribed"}, "others may have subscribers"


def test_three_sites_that_exchange_everything(make_site: MakeSite, endpoint: str) -> None:
    base = make_site("base", EVERYTHING, (), (endpoint,))
    sites = [base, make_site("red", EVERYTHING, (endpoint,)), make_site("blue", EVERYTHING, (endpoint,))]
    publishers: dict[str, Any] = {}
    for site in sites:
        publishers[site.name] = site.node.advertise("/text", "std_msgs/String")
    subscribers = {}
    for site in sites:
        for other in sites:
            if other is not site:
                site.has_topic(f"/{other.name}/text")
                subscribers[site.name, other.name] = QueuedSubscriber(site.node, f"/{other.name}/text")
    for name, publisher in publishers.items():
        wait_for_subscribers(publisher)
        wait_until(partial(_is_wanted_by_both, sites, name), "both others want it")
        publisher.publish(f"from {name}")
    for (_, source), subscriber in subscribers.items():
        assert subscriber.get().data == f"from {source}"
    names = {topic for site in sites for topic in site.topics() if "text" in topic}
    assert names == {"/text", "/red/text", "/blue/text", "/base/text"}, "a topic has gone on to a third site"
    assert all(subscriber.is_silent() for subscriber in subscribers.values())


def _is_wanted_by_both(sites: list[RunningSite], name: str) -> bool:
    return len(_sent(next(site for site in sites if site.name == name), "/text")["wanted_by"]) == 2


def test_two_bridges_on_one_master_send_nothing_of_each_other(make_site: MakeSite, free_ports: Any) -> None:
    from pyros1.bridge.runner import Bridge
    from pyros1.bridge.transport.zenoh_link import ZenohLink

    first, second = (f"tcp/127.0.0.1:{port}" for port in free_ports(2))
    base = make_site("base", EVERYTHING, (), (first,))
    far = make_site("far", EVERYTHING, (), (second,))
    red = make_site("red", EVERYTHING, (first,))
    other_node = red.make_node("second_bridge")
    other = Bridge(other_node, red.rules, lambda receive: ZenohLink("red", receive, (second,)))
    try:
        publisher: Any = base.node.advertise("/text", "std_msgs/String")
        own: Any = red.node.advertise("/own", "std_msgs/String")
        red.has_topic("/base/text")
        far.has_topic("/red/own")
        subscriber = QueuedSubscriber(red.node, "/base/text")
        wait_for_subscribers(publisher)
        publisher.publish("hello")
        subscriber.receives("hello")
        assert not [topic for topic in far.topics() if "text" in topic]
        assert own.name == "/own"
    finally:
        other.close()


@pytest.mark.slow
def test_the_loss_of_the_router_and_its_return(make_site: MakeSite, endpoint: str) -> None:
    base = make_site("base", EVERYTHING.replace("{", "{sites: [red], ", 1), (), (endpoint,))
    red = make_site("red", EVERYTHING, (endpoint,))
    publisher: Any = red.node.advertise("/map", "std_msgs/String", latch=True)
    publisher.publish("before")
    base.has_topic("/red/map")
    subscriber = QueuedSubscriber(base.node, "/red/map")
    subscriber.receives("before")
    base.bridge_node.shutdown()
    wait_until(lambda: subscriptions(publisher) == 0, "red notes that base has left")
    publisher.publish("meanwhile")
    base.restart_bridge()
    subscriber.receives("meanwhile")
    publisher.publish("after")
    subscriber.receives("after")


@pytest.mark.slow
def test_a_latched_cancellation_is_not_carried_out_again(make_site: MakeSite, endpoint: str) -> None:
    """`rostopic pub` latches it, and is often left running."""
    base = make_site("base", "take: [/cancel]", (), (endpoint,))
    red = make_site("red", "send: ['base:/cancel']", (endpoint,))
    cancel: Any = red.node.advertise("/base/cancel", "actionlib_msgs/GoalID", latch=True)
    subscriber = QueuedSubscriber(base.node, "/cancel", "actionlib_msgs/GoalID")
    cancel.publish(id="1")
    assert subscriber.get().id == "1", "it comes, although it was published before the bridge subscribed"
    late = QueuedSubscriber(base.make_node("late"), "/cancel", "actionlib_msgs/GoalID")
    base.bridge_node.shutdown()
    wait_until(lambda: subscriptions(cancel) == 0, "red notes that base has left")
    base.restart_bridge()
    wait_for_subscribers(cancel)
    wait_until(lambda: _sent(red, "/base/cancel")["dropped"] == {"repeated": 1}, "red's bridge gets it again")
    cancel.publish(id="2")
    assert subscriber.get().id == "2" and late.get().id == "2"


@pytest.mark.slow
def test_a_node_that_was_started_again_while_the_other_site_was_away(make_site: MakeSite, endpoint: str) -> None:
    """Its first command is not the repetition of one by its predecessor, which had the same name."""
    base = make_site("base", "take: [/cancel]", (), (endpoint,))
    red = make_site("red", "send: ['base:/cancel']", (endpoint,))
    first: Any = red.make_node("driver").advertise("/base/cancel", "actionlib_msgs/GoalID", latch=True)
    subscriber = QueuedSubscriber(base.node, "/cancel", "actionlib_msgs/GoalID")
    wait_for_subscribers(first)
    first.publish(id="1")
    assert subscriber.get().id == "1"
    base.bridge_node.shutdown()
    wait_until(lambda: subscriptions(first) == 0, "red notes that base has left")
    second: Any = red.make_node("driver").advertise("/base/cancel", "actionlib_msgs/GoalID", latch=True)
    base.restart_bridge()
    wait_for_subscribers(second)
    second.publish(id="2")
    assert subscriber.get().id == "2"


ROUTER = """
import sys
from pyros1.bridge.transport.zenoh_link import ZenohLink
link = ZenohLink("middle", lambda *_: None, (), (sys.argv[1],))
print("ready", flush=True)
sys.stdin.read()
"""


def start_router(endpoint: str) -> subprocess.Popen[str]:
    program = subprocess.Popen(
        [sys.executable, "-c", ROUTER, endpoint], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert program.stdout and program.stdout.readline() == "ready\n"
    return program


def kill(program: subprocess.Popen[str]) -> None:
    program.kill()
    program.wait()
    for stream in (program.stdin, program.stdout):
        assert stream
        stream.close()


@pytest.mark.slow
def test_a_router_in_the_middle_is_killed_and_returns(make_site: MakeSite, endpoint: str) -> None:
    rules = "{send: ['/**', {topic: /event, delivery: reliable}], take: ['*:**']}"
    router = start_router(endpoint)
    try:
        base, red = make_site("base", rules, (endpoint,)), make_site("red", rules, (endpoint,))
        latched: Any = red.node.advertise("/map", "std_msgs/String", latch=True)
        plain: Any = red.node.advertise("/text", "std_msgs/String")
        latched.publish("before")
        for topic in ("/red/map", "/red/text"):
            base.has_topic(topic)
        maps, texts = QueuedSubscriber(base.node, "/red/map"), QueuedSubscriber(base.node, "/red/text")
        maps.receives("before")
        wait_for_subscribers(plain)
        plain.publish("before")
        texts.receives("before")
        kill(router)
        wait_until(lambda: json.loads(base.bridge.status())["sites"][0]["state"] == "lost", "the loss")
        latched.publish("meanwhile")
        plain.publish("meanwhile")
        wait_until(lambda: _sent(red, "/text")["messages"] == 2, "the bridge has taken it")
        router = start_router(endpoint)
        maps.receives("meanwhile")
        # The new router may not know yet that the base wants this topic.
        wait_until(lambda: plain.publish("after") or not texts.is_silent(), "the base gets messages again")
        assert texts.get().data == "after", "what was published during the outage is not delivered later"
    finally:
        kill(router)


@pytest.mark.slow
def test_the_status_says_what_flows(pair: tuple[RunningSite, RunningSite]) -> None:
    red, base = pair
    publisher: Any = red.node.advertise("/text", "std_msgs/String")
    base.has_topic("/red/text")
    subscriber = QueuedSubscriber(base.node, "/red/text")
    wait_for_subscribers(publisher)
    publisher.publish("hello")
    subscriber.receives("hello")
    status = json.loads(base.node.service("/bridge_base/bridge_status", "std_srvs/Trigger")().message)
    assert status["site"] == "base"
    assert [(site["name"], site["state"]) for site in status["sites"]] == [("red", "present")]
    assert status["sites"][0]["round_trip"] > 0
    received = next(entry for entry in status["received"] if entry["local"] == "/red/text")
    assert (received["messages"], received["bytes"], received["state"]) == (1, 9, "subscribed")
    wait_until(lambda: _received(base, "/red/text")["messages_per_second"], "a rate")
    wait_until(lambda: not _received(base, "/red/text")["messages_per_second"], "and its end")
    sent = _sent(red, "/text")
    assert (sent["messages"], sent["wanted_by"]) == (1, ["base"])


@pytest.mark.slow
def test_a_publisher_starts_again_with_another_type(pair: tuple[RunningSite, RunningSite]) -> None:
    red, base = pair
    first = red.make_node("talker")
    texts: Any = first.advertise("/changing", "std_msgs/String", latch=True)
    texts.publish("text")
    base.has_topic("/red/changing")
    subscriber = QueuedSubscriber(base.node, "/red/changing", AnyMsg)  # type: ignore[arg-type]
    assert subscriber.get()._connection_header["type"] == "std_msgs/String"
    first.shutdown()
    numbers: Any = red.make_node("talker").advertise("/changing", "std_msgs/Int64", latch=True)
    numbers.publish(5)
    wait_until(lambda: base.topics().get("/red/changing") == "std_msgs/Int64", "the new type")
    late = QueuedSubscriber(base.make_node("late"), "/red/changing", "std_msgs/Int64")
    assert late.get().data == 5


@pytest.mark.slow
def test_the_master_is_away_for_a_while(pair: tuple[RunningSite, RunningSite]) -> None:
    red, base = pair
    publisher: Any = red.node.advertise("/text", "std_msgs/String")
    base.has_topic("/red/text")
    subscriber = QueuedSubscriber(base.node, "/red/text")
    wait_for_subscribers(publisher)
    port = parse_uri(red.master.uri)[1]
    red.master.stop()
    publisher.publish("meanwhile")
    subscriber.receives("meanwhile")
    red.master = Master(port=port, bind_host="127.0.0.1")
    red.master.start()
    late: Any = red.node.advertise("/late", "std_msgs/String", latch=True)
    late.publish("after")
    base.has_topic("/red/late")
    QueuedSubscriber(base.node, "/red/late").receives("after")


def test_a_slow_site_gets_packets_of_its_own(
    make_site: MakeSite, endpoint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    found: list[Callable[[str], object]] = []

    class ObservedSender(Sender):
        """Keeps the function that is called with a slow site."""

        def __init__(self, link: Any, clock: Any, on_error: Any, make_probes: Any, on_slow: Any) -> None:
            found.append(on_slow)
            super().__init__(link, clock, on_error, make_probes, on_slow)

    monkeypatch.setattr("pyros1.bridge.runner.Sender", ObservedSender)
    base = make_site("base", EVERYTHING, (), (endpoint,))
    red = make_site("red", EVERYTHING, (endpoint,))
    publisher: Any = red.node.advertise("/a", "std_msgs/String")
    base.has_topic("/red/a")
    subscriber = QueuedSubscriber(base.node, "/red/a")
    wait_for_subscribers(publisher)
    found[-1]("base")
    assert [site["slow"] for site in json.loads(red.bridge.status())["sites"]] == [True]
    for number in range(20):
        publisher.publish(f"{number}")
        assert subscriber.get().data == f"{number}"


@pytest.mark.slow
def test_no_connection_is_logged(make_site: MakeSite, endpoint: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bridge.link_report.PATIENCE", 0.0)
    red = make_site("red", EVERYTHING, (endpoint,))  # nobody listens there
    log = QueuedSubscriber(red.node, "/rosout", "rosgraph_msgs/Log")
    while not (text := log.get().msg).startswith("no connection to other sites: "):
        pass
    assert endpoint in text
    make_site("base", EVERYTHING, (), (endpoint,))
    while log.get().msg != "connected to other sites":
        pass
