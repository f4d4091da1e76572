"""parameters: all verbs, and local copies that the master keeps up to date."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.ground.errors import MasterError, MasterUnreachableError, ParameterNotSetError
from pyros1.node.parameters.cache import ParameterCache
from pyros1.node.parameters.parameters import Parameters

from ...parts import context_of, on_loop


@pytest.fixture
def node(make_node: Any) -> Any:
    return make_node("gains", namespace="/robot")


def test_set_get_delete_p22(node: Any) -> None:
    params = node.params
    with pytest.raises(ParameterNotSetError, match="/robot/rate"):
        params["rate"]
    assert params.get("rate") is None and params.get("rate", 7) == 7
    assert "rate" not in params
    params["rate"] = 10
    params.set("~rate", 2.5)
    params["/rate"] = "fast"
    assert (params["rate"], params["~rate"], params["/rate"]) == (10, 2.5, "fast")
    assert params["/robot"] == {"rate": 10, "gains": {"rate": 2.5}}
    assert "rate" in params and "~rate" in params
    assert set(params) == set(params.names()) == {"/robot/rate", "/robot/gains/rate", "/rate"}
    del params["rate"]
    assert "rate" not in params
    with pytest.raises(ParameterNotSetError, match="/robot/rate"):
        del params["rate"]
    with pytest.raises(KeyError):  # as a mapping's
        params["rate"]


@pytest.mark.parametrize("value", [1, -(2**31), 1.5, True, "ä", "", b"\0\xff", [1, "a", [2.5]], {"a": {"b": [True]}}])
def test_values_m49(node: Any, value: Any) -> None:
    node.params["v"] = value
    assert node.params["v"] == value
    assert type(node.params["v"]) is type(value)


class Unanswered:
    """A master that carries out calls whose responses are lost."""

    def __init__(self) -> None:
        self.values: dict[str, Any] = {}

    def subscribe_param(self, uri: str, key: str) -> Any:
        return self.values.get(key, {})

    def set_param(self, key: str, value: Any) -> None:
        self.values[key] = value
        raise MasterUnreachableError("no response")

    def delete_param(self, key: str) -> None:
        del self.values[key]
        raise MasterUnreachableError("no response")


def test_copies_are_right_although_a_response_was_lost() -> None:
    master: Any = Unanswered()
    params = Parameters(master, str, lambda: "http://x:1/", {})
    master.values["/speed"] = 1
    assert params.cached("/speed") == 1
    with pytest.raises(MasterUnreachableError):
        params["/speed"] = 0
    assert params.cached("/speed") == 0
    with pytest.raises(MasterUnreachableError):
        del params["/speed"]
    assert params.cached("/speed") is None


def test_a_dict_replaces_the_namespace_m46(node: Any) -> None:
    node.params["g"] = {"p": 1, "i": 2}
    node.params["g"] = {"p": 3}
    assert node.params["g"] == {"p": 3}


def test_search_m52(node: Any) -> None:
    node.params["/rate"] = 1
    assert node.params.search("rate") == "/rate"
    node.params["rate"] = 2
    assert node.params.search("rate") == "/robot/rate"
    node.params["~rate"] = 3
    assert node.params.search("rate") == "/robot/gains/rate"
    assert node.params.search("nothing") is None
    with pytest.raises(MasterError):
        node.params.search("~rate")


def test_names_are_remapped_n12(make_node: Any) -> None:
    node = make_node("a", argv=["speed:=/limits/speed", "~k:=/k", "_k:=1", "look:=rate"])
    node.params["speed"] = 5
    assert node.params["/limits/speed"] == 5
    node.params["~k"] = 6
    assert node.params["/k"] == 6
    node.params["/rate"] = 7
    assert node.params.search("look") == "/rate"


def test_command_line_parameters_n13(make_node: Any) -> None:
    node = make_node("a", argv=["_rate:=10", "_gain:=2.5", "_frame:=map", "_on:=true", "_list:=[1, a]", "_text:='10'"])
    assert node.params["~"] == {
        "rate": 10, "gain": 2.5, "frame": "map", "on": True, "list": [1, "a"], "text": "10"
    }  # fmt: skip


# Local copies ---------------------------------------------------------------------------------------------------------


@pytest.fixture
def updates(node: Any) -> Any:
    """Let another caller change a parameter, and wait until the node was told."""
    import threading

    told = threading.Condition()
    count = [0]
    update = node.params.update

    def watch(key: str, value: Any) -> bool:
        known: bool = update(key, value)
        with told:
            count[0] += 1
            told.notify_all()
        return known

    node.params.update = watch

    def change(action: Callable[[], object]) -> None:
        before = count[0]
        action()
        with told:
            assert told.wait_for(lambda: count[0] > before, 5)

    return change


@pytest.fixture
def other(make_node: Any) -> Any:
    return make_node("other").params


def test_cached_values_follow_changes(node: Any, other: Any, updates: Any) -> None:
    params = node.params
    assert params.cached("rate", 1) == 1
    updates(lambda: other.set("/robot/rate", 2))
    assert params.cached("rate", 1) == 2
    assert params.cached_names() == ["/robot/rate"]
    updates(lambda: other.__delitem__("/robot/rate"))
    assert params.cached("rate", 1) == 1


def test_changes_by_others_are_told(node: Any, other: Any, updates: Any, collect: Any) -> None:
    calls = collect()
    node.params.on_update(lambda name, value: calls((name, value)))
    assert node.params.cached("rate", 1) == 1
    updates(lambda: other.set("/robot/rate", 2))
    assert calls.wait(1) == [("/robot/rate", 2)]
    updates(lambda: other.__delitem__("/robot/rate"))
    assert calls.wait(2)[1:] == [("/robot/rate", {})]


def test_a_function_that_does_not_return_holds_up_only_its_like(node: Any, other: Any, updates: Any) -> None:
    begun, go_on, told = threading.Event(), threading.Event(), threading.Semaphore(0)

    def stuck(name: str, value: Any) -> None:
        begun.set()
        go_on.wait(20)
        told.release()
        raise ValueError("bad")

    node.params.on_update(stuck)
    assert node.params.cached("rate", 1) == 1
    for value in (2, 3):
        updates(lambda value=value: other.set("/robot/rate", value))
        assert begun.wait(10)
        assert node.params.cached("rate", 1) == value, "the loop takes changes"
    go_on.set()
    assert told.acquire(timeout=10) and told.acquire(timeout=10)


def test_cached_needs_no_master_once_it_is_there(node: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    node.params["rate"] = 3
    assert node.params.cached("rate") == 3
    monkeypatch.setattr(node.master, "call", None)
    assert node.params.cached("rate") == 3


def test_cached_false_values_are_values(node: Any) -> None:
    for value in (0, 0.0, False, "", []):
        node.params["v"] = value
        assert node.params.cached("v", "default") == value


def test_changes_below_and_above_a_cached_name_m53(node: Any, other: Any, updates: Any) -> None:
    params = node.params
    params["/g"] = {"p": 1, "pid": {"i": 2}}
    assert params.cached("/g") == {"p": 1, "pid": {"i": 2}}
    assert params.cached("/g/pid/i") == 2
    updates(lambda: other.set("/g/p", 5))
    assert params.cached("/g") == {"p": 5, "pid": {"i": 2}}
    updates(lambda: other.set("/g/pid/d", 6))
    assert params.cached("/g") == {"p": 5, "pid": {"i": 2, "d": 6}}
    updates(lambda: other.set("/g", {"pid": {"i": 7}}))
    while params.cached("/g/pid/i") != 7 or params.cached("/g") != {"pid": {"i": 7}}:
        pass
    updates(lambda: other.__delitem__("/g"))
    while params.cached("/g/pid/i", "none") != "none" or params.cached("/g", "none") != "none":
        pass


def test_own_changes_reach_the_copy_m54(node: Any) -> None:
    params = node.params
    params["/g/p"] = 1
    assert (params.cached("/g"), params.cached("/g/p")) == ({"p": 1}, 1)
    params["/g/p"] = 2
    assert (params.cached("/g"), params.cached("/g/p")) == ({"p": 2}, 2)
    params["/g"] = {"p": 3, "q": 4}
    assert (params.cached("/g"), params.cached("/g/p")) == ({"p": 3, "q": 4}, 3)


def test_uncache(node: Any, other: Any) -> None:
    node.params["rate"] = 1
    assert node.params.cached("rate") == 1
    node.params.uncache("rate")
    node.params.uncache("rate")
    assert node.params.cached_names() == []
    other["/robot/rate"] = 2
    assert node.params.cached("rate") == 2


def test_the_master_reports_no_changes_after_uncache(node: Any, other: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    updated: list[str] = []
    update = node.params.update
    monkeypatch.setattr(node.params, "update", lambda key, value: updated.append(key) or update(key, value))
    for name in ("rate", "gain"):
        node.params[name] = 1
        assert node.params.cached(name) == 1
    node.params.uncache("rate")
    other["/robot/rate"] = 2
    other["/robot/gain"] = 2
    deadline = time.monotonic() + 15
    while node.params.cached("gain") != 2:  # updates of a node come in their order
        assert time.monotonic() < deadline
    assert [key.rstrip("/") for key in updated] == ["/robot/gain"]


def test_an_update_that_overtakes_the_answer() -> None:
    class Master:
        def subscribe_param(self, api: str, key: str) -> Any:
            assert params.update(key + "/p/", 2)
            assert params.update(key + "/q/", 3)
            return {"p": 1, "r": 4}

    params = Parameters(Master(), lambda name: name, lambda: "", {})  # type: ignore[arg-type]
    assert params.cached("/g") == {"p": 2, "q": 3, "r": 4}


class RacingMaster:
    """A master for one node and its rival, who changes a parameter at the given moment."""

    def __init__(self, when: str) -> None:
        self.value: Any = 0
        self.when = when
        self.late: list[Any] = []  # told to nobody yet
        self.params = Parameters(self, lambda name: name, lambda: "", {})  # type: ignore[arg-type]

    def rival(self, value: Any, notify: bool = True) -> None:
        self.value = value
        if notify:
            self.params.update("/x/", value)
        else:
            self.late.append(value)

    def subscribe_param(self, api: str, key: str) -> Any:
        return self.value

    def set_param(self, key: str, value: Any) -> None:
        if self.when == "before, and told at once":
            self.rival(7)
        elif self.when == "before, and told late":
            self.rival(7, notify=False)
        self.value = value
        if self.when == "after, and told at once":
            self.rival(8)
        elif self.when == "after, and told late":
            self.rival(8, notify=False)


@pytest.mark.parametrize("when", [f"{a}, and told {b}" for a in ("before", "after") for b in ("at once", "late")])
def test_a_copy_ends_with_what_the_master_has_when_two_set_it_at_the_same_time(when: str) -> None:
    master = RacingMaster(when)
    assert master.params.cached("/x") == 0
    master.params["/x"] = 1
    for value in master.late:
        assert master.params.update("/x/", value)
    assert master.params.cached("/x") == master.value == (1 if "before" in when else 8)


def test_a_copy_that_is_fetched_while_both_set_it() -> None:
    class Master(RacingMaster):
        def subscribe_param(self, api: str, key: str) -> Any:
            answer = self.value
            if answer == 0:
                self.rival(5)
                self.params["/x"] = 6
            return answer

    master = Master("never")
    assert master.params.cached("/x") == 6


def test_a_signal_handler_sees_its_own_change_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    master = RacingMaster("never")
    params, got = master.params, []
    assert params.cached("/x") == 0

    def handle() -> None:
        params["/x"] = 4
        got.append(params.cached("/x"))

    set_locally = ParameterCache.set_locally

    def interrupted(copies: ParameterCache, *args: Any) -> None:
        set_locally(copies, *args)
        if not got:
            handle()

    monkeypatch.setattr(ParameterCache, "set_locally", interrupted)
    params["/x"] = 3
    assert got == [4] and params.cached("/x") == 4


def test_copies_above_and_below_what_both_set() -> None:
    class Master(RacingMaster):
        def subscribe_param(self, api: str, key: str) -> Any:
            return {"/": {"x": self.value}, "/x": self.value, "/y": 3}[key]

    master = Master("before, and told at once")
    assert [master.params.cached(key) for key in ("/", "/x", "/y")] == [{"x": 0}, 0, 3]
    master.params["/x"] = 1
    assert [master.params.cached(key) for key in ("/", "/x", "/y")] == [{"x": 1}, 1, 3]


def test_changes_by_several_threads_and_another_node_end_alike(node: Any, other: Any, in_thread: Any) -> None:
    params = node.params
    for _ in range(30):
        params.cached("/x")
        changes = [in_thread(other.set, "/x", 1), in_thread(params.set, "/x", 2), in_thread(params.set, "/x", 3)]
        for change in changes:
            change.join()
        value = params["/x"]
        on_loop(node)
        until = time.monotonic() + 20
        while params.cached("/x") != value and time.monotonic() < until:
            context_of(node).stopping.wait(0.001)  # until the master has told all
        assert params.cached("/x") == value


def test_what_only_one_side_changes_costs_no_call(node: Any, other: Any, updates: Any) -> None:
    params = node.params
    asked: list[str] = []
    subscribe = node.master.subscribe_param
    node.master.subscribe_param = lambda api, key: asked.append(key) or subscribe(api, key)
    assert [params.cached(key, 0) for key in ("/ours", "/theirs")] == [0, 0]
    for number in (1, 2):
        params["/ours"] = number
        updates(lambda number=number: other.set("/theirs", number))
        assert [params.cached(key) for key in ("/ours", "/theirs")] == [number, number]
    assert asked == ["/ours", "/theirs"]


def test_a_failed_subscription_is_tried_again() -> None:
    class Master:
        fail = True

        def subscribe_param(self, api: str, key: str) -> Any:
            if self.fail:
                self.fail = False
                raise MasterError("no")
            return 5

    params = Parameters(Master(), lambda name: name, lambda: "", {})  # type: ignore[arg-type]
    with pytest.raises(MasterError):
        params.cached("/g")
    assert params.cached_names() == []
    assert params.cached("/g") == 5


def test_updates_of_unknown_names_are_refused() -> None:
    params = Parameters(None, lambda name: name, lambda: "", {})  # type: ignore[arg-type]
    assert params.update("/x/", 1) is False


def test_after_the_end_of_the_node_the_master_is_not_blamed(make_node: Any) -> None:
    node = make_node("a")
    node.shutdown()
    with pytest.raises(MasterUnreachableError, match="the calling node has shut down") as raised:
        node.params["/x"]
    assert "pyros1 core" not in str(raised.value)
