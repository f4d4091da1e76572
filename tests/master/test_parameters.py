"""master.parameters: the tree and who hears of its changes (M24-M31, M46-M54, O11)."""

from __future__ import annotations

import contextlib
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.master.parameters import MAX_DEPTH, Parameters, param_updates
from pyros1.wire.xmlrpc import dumps_response


def tree(value: dict[str, Any]) -> Parameters:
    parameters = Parameters()
    parameters.set("/", value)
    return parameters


def test_m46_m47_m48_setting_and_getting() -> None:
    parameters = Parameters()
    parameters.set("/a/b/c", 1)
    assert parameters.get("/") == {"a": {"b": {"c": 1}}}
    assert parameters.get("/a/b/") == parameters.get("//a//b") == {"c": 1}
    parameters.set("/a/b", {"d": 2})
    assert parameters.get("/a") == {"b": {"d": 2}}
    parameters.set("/a/b/d/e", 3)
    assert parameters.get("/a/b/d") == {"e": 3}
    parameters.set("/", {"x": 1})
    assert parameters.get("/") == {"x": 1}
    with pytest.raises(ValueError, match="cannot set root"):
        parameters.set("/", 1)


@pytest.mark.parametrize("key", ["/b", "/a/b/c", "/l/0", "/l/k"])
def test_m25_m50_what_is_not_set(key: str) -> None:
    parameters = tree({"a": {"b": 1}, "l": [{"k": 1}]})
    assert key not in parameters
    with pytest.raises(KeyError):
        parameters.get(key)
    with pytest.raises(KeyError):
        parameters.delete(key)


def test_m27_m31_deleting_and_names() -> None:
    parameters = tree({"a": {"b": 1, "c": {"d": 2}}, "e": {}, "l": [1]})
    assert parameters.names() == ["/a/b", "/a/c/d", "/l"]
    parameters.delete("/a/c/d")
    assert parameters.get("/a/c") == {}
    parameters.delete("/a")
    assert parameters.names() == ["/l"]
    with pytest.raises(KeyError):
        parameters.delete("/")


@pytest.mark.parametrize(
    ("namespace", "key", "found"),
    [
        ("/p/q", "aa", "/p/q/aa"),
        ("/p/q", "zz", "/p/zz"),
        ("/p/q", "top", "/top"),
        ("/p/q", "zz/missing", "/p/zz/missing"),
        ("/p/q", "none", None),
        ("/p/q", "/p/zz", "/p/zz"),
        ("/p/q", "/zz", None),
        ("/p/q", "/", "/"),
        ("/", "p", "/p"),
    ],
)
def test_m52_searching(namespace: str, key: str, found: str | None) -> None:
    parameters = tree({"p": {"q": {"aa": 1}, "zz": 2}, "top": 3})
    assert parameters.search(namespace, key) == found


@pytest.mark.parametrize(("namespace", "key"), [("/p", "~x"), ("p", "x"), ("", "x"), ("/p", "")])
def test_m52_searching_refuses(namespace: str, key: str) -> None:
    with pytest.raises(ValueError, match=r"invalid key|namespace"):
        Parameters().search(namespace, key)


@pytest.mark.parametrize("value", [2**31, -(2**31) - 1, None, [None], {"a": {"b": [2**40]}}])
def test_m49_values_that_could_never_be_sent_are_refused(value: Any) -> None:
    parameters = Parameters()
    with pytest.raises(ValueError, match=r"32 bits|null"):
        parameters.set("/a", value)
    assert parameters.get("/") == {}


def test_depth_is_bounded_so_that_the_whole_tree_can_be_sent() -> None:
    value: Any = 1
    for _ in range(MAX_DEPTH - 2):
        value = {"a": value}
    parameters = Parameters()
    parameters.set("/x/y", value)
    assert dumps_response([1, "", parameters.get("/")])
    for key, deep in (("/x/y/z", value), ("/x/y", [[[value]]]), ("/a" * (MAX_DEPTH + 1), 1)):
        with pytest.raises(ValueError, match="deep"):
            parameters.set(key, deep)
    parameters.set("/a" * MAX_DEPTH, 1)
    assert dumps_response([1, "", parameters.get("/")])


keys = st.lists(st.sampled_from("abc"), max_size=4).map(lambda parts: "/" + "/".join(parts))
values = st.recursive(st.integers(0, 9), lambda inner: st.dictionaries(st.sampled_from("abc"), inner), max_leaves=5)


@pytest.mark.slow
@given(st.lists(st.tuples(keys, values, st.booleans()), max_size=20))
def test_the_tree_behaves_as_nested_dicts(steps: list[tuple[str, Any, bool]]) -> None:
    parameters = Parameters()
    for key, value, delete in steps:
        if delete:
            present = key in parameters and key != "/"
            try:
                parameters.delete(key)
                assert present
            except KeyError:
                assert not present
            assert key == "/" or key not in parameters
        else:
            try:
                parameters.set(key, value)
            except ValueError:
                assert key == "/"
                assert not isinstance(value, dict)
                continue
            assert parameters.get(key) == value
        for name in parameters.names():
            assert not isinstance(parameters.get(name), dict)


@pytest.mark.slow
@given(st.lists(st.tuples(keys, values, st.sampled_from(["set", "delete", "ask"])), max_size=20))
def test_what_is_sent_is_what_is_there(steps: list[tuple[str, Any, str]]) -> None:
    """However texts of branches were kept before."""
    parameters = Parameters()
    for key, value, what in steps:
        with contextlib.suppress(KeyError, ValueError):
            if what == "set":
                parameters.set(key, value)
            elif what == "delete":
                parameters.delete(key)
            else:
                present = parameters.get(key)
                assert dumps_response(present) == dumps_response(plain(present))
    assert dumps_response(parameters.get("/")) == dumps_response(plain(parameters.get("/")))


def plain(value: Any) -> Any:
    return {name: plain(item) for name, item in value.items()} if isinstance(value, dict) else value


SUBSCRIBERS = {"/p": {"/a": "A"}, "/p/q/r": {"/b": "B"}, "/p/q": {"/c": "C"}}


def told(key: str, value: Any, caller: str | None = "/x") -> dict[str, tuple[str, Any]]:
    return {notice.api: (notice.subject, notice.value[0]) for notice in param_updates(SUBSCRIBERS, key, value, caller)}


def test_m53_updates_go_to_subscribers_above_at_and_below() -> None:
    assert told("/p", 1) == {"A": ("/p/", 1)}
    assert told("/p/q/r", 2) == dict.fromkeys("ABC", ("/p/q/r/", 2))
    both = {"r": 3, "s": 4}
    assert told("/p/q", both) == {"A": ("/p/q/", both), "B": ("/p/q/r/", 3), "C": ("/p/q/", both)}
    assert told("/p/q", {"s": 4})["B"] == ("/p/q/r/", {})
    assert told("/p", {"q": 5}) == {"A": ("/p/", {"q": 5}), "B": ("/p/q/r/", {}), "C": ("/p/q/", 5)}
    assert told("/", {"p": {"z": 1}}) == {"A": ("/p/", {"z": 1}), "B": ("/p/q/r/", {}), "C": ("/p/q/", {})}
    assert told("/p/q/r/u/v", 5) == dict.fromkeys("ABC", ("/p/q/r/u/v/", 5))
    assert told("/pp", 1) == {}
    assert told("/p/qq", 1) == {"A": ("/p/qq/", 1)}


def test_m54_whoever_set_a_key_is_not_told_its_value_but_a_deletion_is_told_to_all() -> None:
    assert set(told("/p/q/r", 1, caller="/a")) == {"B", "C"}
    assert set(told("/p/q", {}, caller=None)) == {"A", "B", "C"}


def test_updates_carry_the_value_of_their_time() -> None:
    parameters = tree({"p": {"q": 1}})
    (notice,) = param_updates({"/p": {"/a": "A"}}, "/p", parameters.get("/p"), "/x")
    parameters.set("/p/q", 2)
    assert notice.value == ({"q": 1},)
    assert param_updates({}, "/p", 1, None) == []


def test_a_change_of_one_value_costs_no_look_at_each_subscribed_key() -> None:
    class Asked(dict[str, dict[str, str]]):
        def __iter__(self) -> Any:
            raise AssertionError("all keys were looked at")

        keys = values = items = __iter__

    (notice,) = param_updates(Asked({f"/n{i}/p": {f"/n{i}": f"API{i}"} for i in range(1000)}), "/n7/p/q", 1, "/x")
    assert (notice.api, notice.subject) == ("API7", "/n7/p/q/")


def test_a_key_is_found_from_the_root_down() -> None:
    subscribers = {"/p": {"/a": "A"}, "/": {"/root": "R"}, "/p/q": {"/b": "B"}}
    assert [notice.api for notice in param_updates(subscribers, "/p/q", 1, None)] == ["R", "A", "B"]
    assert [notice.api for notice in param_updates(subscribers, "/", {"p": 1}, None)] == ["R", "A", "B"]
