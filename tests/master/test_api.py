"""master.api: the triples, in stock's words (M03-M31, O12)."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import XmlRpcFault
from pyros1.master.api import METHODS, MasterApi

A = "http://a:1/"
R = "rosrpc://a:2"


class Fixture:
    def __init__(self) -> None:
        self.lines: list[str] = []
        self.reasons: list[str] = []
        self.api = MasterApi(
            notify=lambda notices: None,
            log=lambda level, text: self.lines.append(f"{level} {text}"),
            on_shutdown=self.reasons.append,
            pid=42,
        )

    def call(self, method: str, *params: Any) -> list[Any]:
        return self.api.dispatch(method, params)


@pytest.fixture
def master() -> Fixture:
    return Fixture()


def test_m11_m12_m13_about_the_master(master: Fixture) -> None:
    master.api.uri = "http://m:1/"
    assert master.call("getPid", "/a") == [1, "", 42]
    assert master.call("getUri", "/a") == [1, "", "http://m:1/"]
    assert master.call("shutdown", "/a", "why") == [1, "shutdown", 0]
    assert master.reasons == ["why"]


DEFAULTS: dict[str, Any] = {
    **dict.fromkeys(METHODS, 0),
    **{method: [] for method in ("registerPublisher", "registerSubscriber", "getTopicTypes", "getParamNames")},
    **{"getPid": -1, "getUri": "", "lookupService": "", "lookupNode": "", "getSystemState": [[], [], []]},
    "hasParam": False,
}
"""The values of answers that report an error."""


@pytest.mark.parametrize("method", sorted(METHODS))
def test_m06_caller_id_and_arity(master: Fixture, method: str) -> None:
    default = DEFAULTS[method]
    count = len(METHODS[method].arguments)
    assert master.call(method) == [-1, "missing required caller_id parameter", default]
    assert master.call(method, "/a", *[1] * (count + 1)) == [-1, "Error: bad call arity", default]
    assert master.call(method, 3, *["x"] * count) == [-1, "caller_id must be a string", default]


def test_m05_unknown_methods_are_faults(master: Fixture) -> None:
    for method in ("nope", "_shutdown", "dispatch", "system.listMethods", ""):
        with pytest.raises(XmlRpcFault, match="is not supported"):
            master.call(method, "/a")


@pytest.mark.parametrize(
    ("call", "answer"),
    [
        (("registerPublisher", "/n", "/", "a/b", A), "parameter [topic] cannot be the global namespace"),
        (("registerPublisher", "/n", "", "a/b", A), "parameter [topic] must be a non-empty string"),
        (("registerPublisher", "/n", 3, "a/b", A), "parameter [topic] must be a non-empty string"),
        (("registerPublisher", "/n", "a b", "a/b", A), "parameter [topic] contains illegal chars"),
        (("registerPublisher", "/n", "a:b", "a/b", A), "parameter [topic] contains illegal chars"),
        (("registerPublisher", "/n", "x", "ab", A), "parameter [topic_type] is not a valid package resource name"),
        (("registerPublisher", "/n", "x", "a/b/c", A), "parameter [topic_type] is not a valid package resource name"),
        (("registerSubscriber", "/n", "x", "", A), "parameter [topic_type] must be a non-empty string"),
        (("registerPublisher", "/n", "x", "a/b", "h"), "parameter [caller_api] is not an RPC URI"),
        (("registerPublisher", "/n", "x", "a/b", ""), "parameter [caller_api] is not an XMLRPC URI"),
        (("registerPublisher", "/n", "x", "a/b", 4), "parameter [caller_api] is not an XMLRPC URI"),
        (("registerService", "/n", "s", "h", A), "parameter [service_api] is not an RPC URI"),
        (("registerService", "/n", "/", R, A), "parameter [service] cannot be the global namespace"),
        (("lookupNode", "/n", 3), "parameter [node] must be a non-empty string"),
        (("getPublishedTopics", "/n", 3), "parameter [subgraph] must be a string"),
        (("getParam", "/n", ""), "parameter [key] must be specified and non-empty"),
        (("getParam", "/n", 3), "parameter [key] must be a string"),
        (("setParam", "/n", "k", None), "parameter [value] must be specified"),
    ],
)
def test_m09_m10_wrong_arguments(master: Fixture, call: tuple[Any, ...], answer: str) -> None:
    assert master.call(*call) == [-1, "ERROR: " + answer, METHODS[call[0]].default]


def test_m08_m51_names_are_resolved_against_the_caller(master: Fixture) -> None:
    for name, resolved in (("t", "/ns/t"), ("~t", "/ns/n/t"), ("//a///t/", "/a/t"), ("a-t", "/ns/a-t")):
        answer = master.call("registerPublisher", "/ns/n", name, "a/b", A)
        assert answer == [1, f"Registered [/ns/n] as publisher of [{resolved}]", []]
        assert master.call("setParam", "/ns/n", name, 1) == [1, f"parameter {resolved} set", 0]
        assert master.call("getParam", "/x", resolved) == [1, f"Parameter [{resolved}]", 1]


def test_m14_to_m20_topics_services_nodes(master: Fixture) -> None:
    call = master.call
    assert call("registerSubscriber", "/s", "t", "*", A) == [1, "Subscribed to [/t]", []]
    assert call("registerPublisher", "/p", "t", "a/b", A) == [1, "Registered [/p] as publisher of [/t]", [A]]
    assert call("registerSubscriber", "/s", "t", "*", A) == [1, "Subscribed to [/t]", [A]]
    assert call("unregisterPublisher", "/p", "t", A + "x") == [1, "[/p] is not a known provider of [/t]", 0]
    assert call("unregisterPublisher", "/p", "t", A) == [1, "Unregistered [/p] as provider of [/t]", 1]
    assert call("unregisterPublisher", "/p", "t", A) == [1, "[/p] is not a registered node", 0]
    assert call("unregisterSubscriber", "/s", "t", A) == [1, "Unregistered [/s] as provider of [/t]", 1]
    assert call("registerService", "/p", "s", R, A) == [1, "Registered [/p] as provider of [/s]", 1]
    assert call("lookupService", "/x", "s") == [1, f"rosrpc URI: [{R}]", R]
    assert call("lookupNode", "/x", "/p") == [1, "node api", A]
    gone = f"[{R}9] is no longer the current service api handle for [/s]"
    assert call("unregisterService", "/p", "s", R + "9") == [1, gone, 0]
    assert call("unregisterService", "/p", "s", R) == [1, "Unregistered [/p] as provider of [/s]", 1]
    assert call("lookupService", "/x", "s") == [-1, "no provider", ""]
    assert call("lookupNode", "/x", "/p") == [-1, "unknown node [/p]", ""]
    assert call("getPublishedTopics", "/x", "") == [1, "current topics", []]
    assert call("getTopicTypes", "/x") == [1, "current system state", [["/t", "a/b"]]]
    assert call("getSystemState", "/x") == [1, "current system state", [[], [], []]]


def test_m24_to_m31_parameters(master: Fixture) -> None:
    call = master.call
    assert call("setParam", "/n", "/a", {"b": 1}) == [1, "parameter /a set", 0]
    assert call("getParam", "/n", "/c") == [-1, "Parameter [/c] is not set", 0]
    assert call("hasParam", "/n", "/a/b/") == [1, "/a/b", True]
    assert call("hasParam", "/n", "/c") == [1, "/c", False]
    assert call("getParamNames", "/n") == [1, "Parameter names", ["/a/b"]]
    assert call("searchParam", "/a/n", "b") == [1, "Found [/a/b]", "/a/b"]
    assert call("searchParam", "/n", "zz") == [-1, "Cannot find parameter [zz] in an upwards search", ""]
    assert call("searchParam", "/n", "~b") == [0, "Internal failure: invalid key", 0]
    assert call("searchParam", "n", "b") == [0, "Internal failure: namespace must be global", 0]
    assert call("subscribeParam", "/n", A, "/a") == [1, "Subscribed to parameter [/a]", {"b": 1}]
    assert call("subscribeParam", "/n", A, "/none") == [1, "Subscribed to parameter [/none]", {}]
    assert call("unsubscribeParam", "/n", A, "/never") == [1, "Unsubscribe to parameter [/never]", 1]
    assert call("deleteParam", "/n", "/a") == [1, "parameter /a deleted", 0]
    assert call("deleteParam", "/n", "/a") == [-1, "parameter [/a] is not set", 0]
    assert call("deleteParam", "/n", "/") == [-1, "parameter [/] is not set", 0]
    root = "Error: invalid arguments: cannot set root of parameter tree to non-dictionary"
    assert call("setParam", "/n", "/", 1) == [-1, root, 0]


def test_m57_changes_are_logged(master: Fixture) -> None:
    call = master.call
    call("registerPublisher", "/n", "t", "a/b", A)
    call("registerSubscriber", "/n", "t", "a/b", A)
    call("registerService", "/n", "s", R, A)
    call("setParam", "/n", "p", 1)
    call("subscribeParam", "/n", A, "p")
    call("unsubscribeParam", "/n", A, "p")
    call("deleteParam", "/n", "p")
    call("unregisterService", "/n", "s", R)
    call("unregisterSubscriber", "/n", "t", A)
    call("unregisterPublisher", "/n", "t", A)
    assert master.lines == [
        f"info +PUB [/t] /n {A}",
        f"info +SUB [/t] /n {A}",
        f"info +SERVICE [/s] /n {A}",
        "info +PARAM [/p] by /n",
        "info +CACHEDPARAM [/p] by /n",
        "info -CACHEDPARAM [/p] by /n",
        "info -PARAM [/p] by /n",
        f"info -SERVICE [/s] /n {R}",
        f"info -SUB [/t] /n {A}",
        f"info -PUB [/t] /n {A}",
    ]


unchecked = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**40), 2**40)
    | st.text(max_size=8)
    | st.sampled_from(["/a", "~b", A, R, "a/b", "/"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=5,
)


@pytest.mark.slow
@given(st.lists(st.tuples(st.sampled_from(sorted(METHODS)), st.lists(unchecked, max_size=5)), max_size=15))
def test_m03_any_call_gets_a_triple(calls: list[tuple[str, list[Any]]]) -> None:
    master = Fixture()
    for method, params in calls:
        code, message, value = master.call(method, *params)
        assert code in (1, 0, -1)
        assert isinstance(message, str)
        assert value is not None
