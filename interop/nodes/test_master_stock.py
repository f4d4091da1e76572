"""The same calls to rosmaster and to our master: the same answers, and the same notifications to nodes (M03-M55).

They differ on purpose in this, and the tests named ``deliberate`` show it:

- Subscribers of a node that lost its name to another are told; stock tells nobody (M35).
- Values that could be stored but never be read again are refused: null in a container, ints beyond 32 bits.
- A provider whose service was taken over leaves nothing behind when it unregisters; stock then knows its node for ever.
- A replaced node that is told to end can read parameters, but does not get its name back with that.
- Deleting a key below a scalar is answered with "not set"; stock shows a Python error in the same -1.
- Of notifications about the same thing that wait for a busy node only the newest is sent.

Feature: the master behaves like rosmaster -- same calls, same replies
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import Any

import pytest
from master_pair import Side, pair, told

A, B, C = "http://a:1/", "http://b:2/", "http://c:3/"
R = "rosrpc://h:3"
X = "/ns/me"

Pair = tuple[Side, Side]


@pytest.fixture(scope="module")
def sides(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Pair]:
    with pair(tmp_path_factory.mktemp("rosmaster"), {}) as both:
        yield both


@pytest.fixture(scope="module")
def told_sides(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Pair]:
    """A pair that never hears of nodes that do not exist: looking for those holds up stock's workers for seconds."""
    recorders = {"A": (1, "", 0), "B": (1, "", 0), "C": (-1, "not subscribed", 0)}
    with pair(tmp_path_factory.mktemp("rosmaster"), recorders) as both:
        yield both


def same(sides: Pair, method: str, *params: Any) -> Any:
    stock, ours = (side.call(method, *params) for side in sides)
    if method == "deleteParam" and stock[1].startswith("Error: invalid arguments"):
        stock[1] = ours[1]
    assert ours == stock, f"{method}{params}"
    return ours


METHODS = {
    "getUri": 0,
    "registerPublisher": 3,
    "registerSubscriber": 3,
    "unregisterPublisher": 2,
    "unregisterSubscriber": 2,
    "registerService": 3,
    "unregisterService": 2,
    "lookupService": 1,
    "lookupNode": 1,
    "getPublishedTopics": 1,
    "getTopicTypes": 0,
    "getSystemState": 0,
    "setParam": 2,
    "getParam": 1,
    "hasParam": 1,
    "deleteParam": 1,
    "searchParam": 1,
    "getParamNames": 0,
    "subscribeParam": 2,
    "unsubscribeParam": 2,
}
ODD = [
    3,
    0,
    "",
    [],
    {},
    None,
    True,
    1.5,
    "/",
    "~",
    "a b",
    "a:b",
    "//x//",
    "x-y",
    "~/x",
    "/x/",
    "h",
    "http://",
    "*",
    "/a/b",
]


@pytest.mark.parametrize("method", METHODS)
def test_m06_arity_and_caller_id(sides: Pair, method: str) -> None:
    for count in range(METHODS[method] + 3):
        if count - 1 != METHODS[method]:
            same(sides, method, *["/me"] * count)
    for caller in (3, None, [], True):
        same(sides, method, caller, *["/x"] * METHODS[method])


@pytest.mark.parametrize("method", METHODS)
def test_m09_m10_odd_arguments(sides: Pair, method: str) -> None:
    good = {"registerPublisher": ["t", "a/b", A], "registerSubscriber": ["t", "a/b", A]}.get(method)
    if good is None:
        good = {"registerService": ["s", R, A], "unregisterService": ["s", R]}.get(method, ["t", A][: METHODS[method]])
    if method in ("subscribeParam", "unsubscribeParam"):
        good = [A, "/p"]
    for position in range(METHODS[method]):
        for index, odd in enumerate(ODD):
            if method == "setParam" and position == 0 and odd == "/":
                continue
            params: list[Any] = list(good)
            params[position] = odd
            # One caller per call: a replaced node that subscribes to a parameter is a deliberate difference.
            same(sides, method, f"{X}/{position}/{index}", *params)


def test_m05_unknown_methods(sides: Pair) -> None:
    for method in ("nope", "_x", "_shutdown", "system.listMethods", "getBusInfo", "getMasterUri", "requestTopic"):
        same(sides, method, "/me")
        same(sides, method)


def test_m11_pid(sides: Pair) -> None:
    for side in sides:
        code, message, pid = side.call("getPid", "/me")
        assert (code, message) == (1, "")
        assert pid > 0
    same(sides, "getPid", 3)
    same(sides, "getPid", "/me", 1)


def test_m04_multicall(sides: Pair) -> None:
    calls = [
        {"methodName": "setParam", "params": ["/me", "/multi", {"a": [1, "x"]}]},
        {"methodName": "getParam", "params": ["/me", "/multi"]},
        {"methodName": "getParam", "params": ["/me"]},
        {"methodName": "getParam", "params": []},
        {"methodName": "deleteParam", "params": ["/me", "/multi"]},
        {"methodName": "deleteParam", "params": ["/me", "/multi"]},
    ]
    same(sides, "system.multicall", calls)
    same(sides, "system.multicall", [])
    for side in sides:
        (result,) = side.call("system.multicall", [{"methodName": "nope", "params": ["/me"]}])
        assert result["faultCode"] == 1
        assert result["faultString"].endswith('method "nope" is not supported')


def test_m14_to_m23_registrations(sides: Pair) -> None:
    for topic, kind in (
        ("chat", "a/b"),
        ("~c", "a/b"),
        ("//x///y/", "*"),
        ("x-y", "a/b"),
        ("/ch", "*"),
        ("/ch", "a/c"),
    ):
        same(sides, "registerSubscriber", "/r/sub", topic, kind, A)
        same(sides, "registerPublisher", "/r/pub", topic, kind, B)
        same(sides, "registerPublisher", "/r/pub", topic, "*", B)
        same(sides, "registerPublisher", "/r/pub2", topic, "a/d", C)
        same(sides, "registerSubscriber", "/r/sub", topic, "a/e", A)
    for subgraph in ("", "/", "/r", "/r/", "r", "~", "/ch", "/r/pub", "none", "/x//"):
        same(sides, "getPublishedTopics", "/r/me", subgraph)
    same(sides, "getTopicTypes", "/me")
    same(sides, "getSystemState", "/me")
    for api in (A, B, A):
        same(sides, "unregisterSubscriber", "/r/sub", "chat", api)
        same(sides, "unregisterPublisher", "/r/pub", "chat", api)
        same(sides, "unregisterPublisher", "/r/never", "chat", api)
    for service, uri in (("add", R), ("~add", R + "1"), ("/add", R + "2")):
        same(sides, "registerService", "/r/s", service, uri, A)
        same(sides, "lookupService", "/r/me", service)
    same(sides, "registerService", "/r/s2", "add", R + "4", B)
    same(sides, "unregisterService", "/r/s", "add", R)
    same(sides, "lookupService", "/r/me", "add")
    same(sides, "getSystemState", "/me")
    same(sides, "unregisterService", "/r/s2", "add", R)
    same(sides, "unregisterService", "/r/s2", "add", R + "4")
    for node in ("/r/s", "s", "~s", "/r/s2", "/r/pub", "/r/sub", "/", "none"):
        same(sides, "lookupNode", "/r/me", node)


TREES: list[Any] = [
    1, -1, 0, True, False, 1.5, "", "text", "é<&>", [], [1, "a", [2.5]], {}, {"a": 1}, {"a": {"b": {"c": 1}}, "d": {}},
    {"": 1}, {"a/b": 2}, {" ": 3}, [{"a": 1}], {"q": {"r": 7, "s": {"t": 8}}},
]  # fmt: skip
KEYS = [
    "a",
    "/a",
    "/a/b",
    "/a/b/c",
    "~a",
    "/a/",
    "//a//b",
    "/",
    "/p/q",
    "/p/q/r",
    "q",
    "/p",
    "~",
    "/p/q/s/t",
    "/zz",
    "b/c",
]


def same_tree(sides: Pair) -> None:
    same(sides, "getParam", "/me", "/")
    same(sides, "getParamNames", "/me")


@pytest.mark.parametrize("seed", range(4))
def test_m46_to_m52_random_parameter_traffic(sides: Pair, seed: int) -> None:
    chance = random.Random(seed)
    same(sides, "setParam", "/me", "/", {})
    for step in range(250):
        caller = chance.choice(["/me", "/p/q/me", "/a", "/", "/p/"])
        key = chance.choice(KEYS)
        what = chance.choice(["setParam", "setParam", "getParam", "hasParam", "deleteParam", "searchParam"])
        same(sides, what, caller, key, *([chance.choice(TREES)] if what == "setParam" else []))
        if step % 10 == 0:
            same_tree(sides)
    same_tree(sides)


@pytest.mark.parametrize("seed", range(4))
def test_m14_to_m37_random_registrations(sides: Pair, seed: int) -> None:
    chance = random.Random(seed)
    nodes = [f"/rnd{seed}/{name}" for name in "abc"]
    apis = dict(zip(nodes, (A, B, C), strict=True))
    newest = dict(apis)  # a replaced node that subscribes to a parameter is a deliberate difference
    topics = ["t", "/t", "~t", "/u/v"]
    for step in range(250):
        node = chance.choice(nodes)
        api = apis[node] if chance.random() < 0.9 else chance.choice([A, B, C])
        topic = chance.choice(topics)
        what = chance.choice(sorted(METHODS))
        if what.startswith("register"):
            newest[node] = api
        if what in ("registerPublisher", "registerSubscriber"):
            same(sides, what, node, topic, chance.choice(["*", "a/b", "a/c"]), api)
        elif what in ("unregisterPublisher", "unregisterSubscriber"):
            same(sides, what, node, topic, api)
        elif what == "registerService":
            # each service has one possible provider: otherwise see the top
            same(sides, what, node, f"~{topic.strip('~/')}", chance.choice([R, R + "1"]), api)
        elif what == "unregisterService":
            same(sides, what, node, f"~{topic.strip('~/')}", chance.choice([R, R + "1"]))
        elif what in ("subscribeParam", "unsubscribeParam"):
            same(sides, what, node, newest[node], chance.choice(["/k", "~k"]))
        elif what in ("lookupNode", "getPublishedTopics"):
            same(sides, what, "/me", node)
        if step % 10 == 0:
            same(sides, "getSystemState", "/me")
            same(sides, "getTopicTypes", "/me")


def steps_of_notifications() -> list[tuple[Any, ...]]:
    return [
        ("setParam", "/x", "/", {}),
        ("subscribeParam", "/a", "A", "/p"),
        ("subscribeParam", "/b", "B", "/p/q/r"),
        ("subscribeParam", "/c", "C", "/p/q"),
        ("setParam", "/x", "/p", 1),
        ("setParam", "/x", "/p/q/r", 2),
        ("setParam", "/x", "/p/q", {"r": 3, "s": 4}),
        ("setParam", "/x", "/p/q", {"s": 4}),
        ("setParam", "/x", "/p/q/s", 5),
        ("setParam", "/x", "/p", {"q": {"r": {"u": 1}}}),
        ("setParam", "/a", "/p/q/r/u", 6),
        ("setParam", "/b", "/p", {"q": {"r": 7}}),
        ("setParam", "/x", "/pp", 8),
        ("setParam", "/x", "/", {"p": {"z": 1}}),
        ("setParam", "/x", "/p/q", {"r": 7}),
        ("deleteParam", "/x", "/p/q/r"),
        ("deleteParam", "/b", "/p/q"),
        ("deleteParam", "/x", "/p"),
        ("setParam", "/x", "/p", "scalar"),
        ("setParam", "/x", "/p", {"q": 5}),
        ("setParam", "/x", "/p/q/r/u/v", 5),
        ("unsubscribeParam", "/b", "B", "/p/q/r"),
        ("unsubscribeParam", "/c", "C", "/p/q"),
        ("unsubscribeParam", "/a", "A", "/p"),
        ("setParam", "/x", "/p", 1),
        ("subscribeParam", "/a", "A", "/"),
        ("setParam", "/x", "/k", 1),
        ("setParam", "/x", "/", {"k": 2}),
        ("unsubscribeParam", "/a", "A", "/"),
        ("registerSubscriber", "/sub", "/t1", "a/b", "B"),
        ("registerPublisher", "/n", "/t1", "a/b", "A"),
        ("registerPublisher", "/n", "/t1", "a/b", "A"),
        ("registerPublisher", "/m", "/t1", "a/c", "C"),
        ("registerSubscriber", "/sub2", "/t1", "*", "C"),
        ("unregisterPublisher", "/n", "/t1", "A"),
        ("unregisterPublisher", "/m", "/t1", "C"),
        ("unregisterSubscriber", "/sub", "/t1", "B"),
        ("registerService", "/sv", "/svc", R, "A"),
        ("registerService", "/sv", "/svc", R + "3", "B"),
        ("subscribeParam", "/pq", "A", "/p1"),
        ("subscribeParam", "/pq", "B", "/p2"),
        ("setParam", "/x", "/p1", 1),
        ("setParam", "/x", "/p2", 1),
        ("registerSubscriber", "/n2", "/t9", "*", "A"),
        ("registerPublisher", "/n2", "/t8", "a/b", "B"),
        ("registerPublisher", "/n3", "/t9", "a/b", "B"),
    ]


def test_m34_m38_m53_m54_nodes_are_told_the_same(told_sides: Pair) -> None:
    sides = told_sides
    for step in steps_of_notifications():
        same(sides, *step)
        stock, ours = told(sides)
        assert ours == stock, step


def test_deliberate_m35_subscribers_hear_of_a_takeover(told_sides: Pair) -> None:
    sides = told_sides
    same(sides, "registerSubscriber", "/listener", "/taken", "a/b", "B")
    same(sides, "registerPublisher", "/taker", "/taken", "a/b", "A")
    stock, ours = told(sides, least=1)
    assert ours == stock == [["B", "publisherUpdate", "/master", "/taken", ["A"]]]
    same(sides, "registerSubscriber", "/taker", "/else", "a/b", "C")
    extra = ["B", "publisherUpdate", "/master", "/taken", []]
    stock, ours = told(sides, [extra], least=1)
    shutdown = ["A", "shutdown", "/master", "[/taker] Reason: new node registered with same name"]
    assert stock == [shutdown]
    assert ours == [shutdown, extra]


def test_deliberate_a_replaced_node_does_not_take_its_name_back_to_read_a_parameter(told_sides: Pair) -> None:
    sides = told_sides
    same(sides, "registerPublisher", "/renewed", "/news", "a/b", "A")
    same(sides, "registerPublisher", "/renewed", "/news", "a/b", "B")
    stock, ours = told(sides, least=1)
    shutdown = ["shutdown", "/master", "[/renewed] Reason: new node registered with same name"]
    assert ours == stock == [["A", *shutdown]]
    same(sides, "subscribeParam", "/renewed", "A", "/tcp_keepalive")
    stock, ours = told(sides, [])
    assert stock == [["B", *shutdown]] and ours == []


def test_deliberate_values_that_stock_could_never_give_back(sides: Pair) -> None:
    stock, ours = sides
    for value in ([None], {"a": None}):
        assert stock.call("setParam", "/me", "/odd", value)[0] == 1
        assert stock.call("getParam", "/me", "/odd")[0] == "fault"
        assert ours.call("setParam", "/me", "/odd", value)[0] == -1
    stock.call("deleteParam", "/me", "/odd")


def test_deliberate_a_replaced_provider_leaves_nothing_behind(sides: Pair) -> None:
    same(sides, "registerService", "/old", "/replaced", R, A)
    same(sides, "registerService", "/new", "/replaced", R + "1", B)
    same(sides, "unregisterService", "/old", "/replaced", R)
    stock, ours = (side.call("lookupNode", "/me", "/old") for side in sides)
    assert stock == [1, "node api", A]
    assert ours == [-1, "unknown node [/old]", ""]
