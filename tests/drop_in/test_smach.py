"""smach by pyros1: machines as the tutorials of https://wiki.ros.org/smach build them."""

from __future__ import annotations

import inspect
import threading
from collections.abc import Iterator
from typing import Any

import pytest
from smach_modules import imported


@pytest.fixture
def smach() -> Iterator[Any]:
    with imported("smach") as module:
        said: list[str] = []
        module.set_loggers(*([said.append] * 4))
        module.said = said
        yield module


def counting(smach: Any) -> Any:
    """Return the machine of the tutorial on userdata: two states, of which one counts."""

    class Foo(smach.State):
        def __init__(self) -> None:
            smach.State.__init__(self, ["outcome1", "outcome2"], ["foo_counter_in"], ["foo_counter_out"])

        def execute(self, userdata: Any) -> str:
            if userdata.foo_counter_in < 3:
                userdata.foo_counter_out = userdata.foo_counter_in + 1
                return "outcome1"
            return "outcome2"

    class Bar(smach.State):
        def __init__(self) -> None:
            smach.State.__init__(self, outcomes=["outcome1"], input_keys=["bar_counter_in"])
            self.seen: list[int] = []

        def execute(self, userdata: Any) -> str:
            self.seen.append(userdata["bar_counter_in"])
            return "outcome1"

    machine = smach.StateMachine(outcomes=["outcome4"])
    machine.userdata.sm_counter = 0
    with machine:
        remapping = {"foo_counter_in": "sm_counter", "foo_counter_out": "sm_counter"}
        smach.StateMachine.add("FOO", Foo(), {"outcome1": "BAR", "outcome2": "outcome4"}, remapping)
        smach.StateMachine.add("BAR", Bar(), {"outcome1": "FOO"}, {"bar_counter_in": "sm_counter"})
    return machine


def test_states_pass_userdata(smach: Any) -> None:
    machine = counting(smach)
    assert machine.execute() == "outcome4"
    assert machine.userdata.sm_counter == 3
    assert machine["BAR"].seen == [1, 2, 3]
    assert smach.said[0] == "State machine starting in initial state 'FOO' with userdata: \n\t['sm_counter']"
    assert smach.said[1] == "State machine transitioning 'FOO':'outcome1'-->'BAR'"
    assert smach.said[-1] == "State machine terminating 'FOO':'outcome2':'outcome4'"


def test_introspection(smach: Any) -> None:
    machine = counting(smach)
    assert machine.get_initial_states() == ["FOO"]
    assert machine.get_active_states() == ["None"]
    assert sorted(machine.get_internal_edges()) == [
        ("outcome1", "BAR", "FOO"),
        ("outcome1", "FOO", "BAR"),
        ("outcome2", "FOO", "outcome4"),
    ]
    machine.set_initial_state(["BAR"])
    machine.userdata.sm_counter = 3
    assert machine.execute() == "outcome4"
    assert machine["BAR"].seen == [3]


def test_callbacks_of_a_container(smach: Any) -> None:
    machine, calls = counting(smach), []
    machine.userdata.sm_counter = 2
    machine.register_start_cb(lambda ud, states, word: calls.append((word, states)), ["start"])
    machine.register_transition_cb(lambda ud, states: calls.append((ud.sm_counter, states)))
    machine.register_termination_cb(lambda ud, states, outcome: calls.append((states, outcome)))
    machine.execute()
    assert calls == [("start", ["FOO"]), (3, ["BAR"]), (3, ["FOO"]), (["FOO"], "outcome4")]


def test_nested_machines_share_what_they_declare(smach: Any) -> None:
    @smach.cb_interface(input_keys=["x"], output_keys=["y"], outcomes=["done"])
    def double(userdata: Any) -> str:
        userdata.y = 2 * userdata.x
        return "done"

    top = smach.StateMachine(["end"])
    top.userdata.value = 4
    with top:
        inner = smach.StateMachine(["finished"], input_keys=["x"], output_keys=["y"])
        with inner:
            smach.StateMachine.add("DOUBLE", smach.CBState(double), {"done": "finished"})
        smach.StateMachine.add("INNER", inner, {"finished": "end"}, {"x": "value", "y": "result"})
    assert top.execute() == "end"
    assert (top.userdata.result, sorted(top.userdata.keys())) == (8, ["result", "value"])


def test_access_to_userdata_is_declared(smach: Any) -> None:
    class Thing:
        def __init__(self) -> None:
            self.size = 1
            self.parts = [1, 2]

        def grow(self) -> None:
            self.size += 1

        def total(self) -> int:
            return self.size + len(self.parts)

    data = smach.UserData()
    data.a, data.b, data.thing = 1, 2, Thing()
    view = smach.Remapper(data, ["a", "thing"], ["c"], {"c": "b"})
    assert (view.a, view["a"], view.keys(), "a" in view, "b" in view) == (1, 1, ["a", "thing"], True, False)
    view.c = 5
    assert data.b == 5
    with pytest.raises(smach.InvalidUserCodeError, match="Reading from SMACH userdata key 'b'"):
        _ = view.b
    with pytest.raises(smach.InvalidUserCodeError, match="Writing to SMACH userdata key 'a'"):
        view.a = 2
    assert isinstance(view.thing, Thing) and view.thing.total() == 3
    for change in (view.thing.grow, lambda: setattr(view.thing, "size", 3)):
        with pytest.raises(TypeError, match="read-only"):
            change()
    smach.Remapper(data, ["thing"], ["thing"]).thing.grow()
    assert data.thing.size == 2
    with pytest.raises(KeyError):
        _ = data.nothing
    with pytest.raises(AttributeError):
        _ = data.nothing


def test_userdata_can_be_taken_apart(smach: Any) -> None:
    data = smach.UserData()
    data.a, data.b = 1, 2
    part = data.extract(["a"], {"x": "a"})
    assert (part.keys(), part.x) == (["x"], 1)
    part.x = 7
    data.merge(part, ["x"], {"x": "b"})
    other = smach.UserData()
    other.update(data)
    assert (other.a, other.b) == (1, 7)


def test_sequences_and_auto(smach: Any) -> None:
    order: list[str] = []

    def state(name: str, *outcomes: str) -> Any:
        return smach.CBState(lambda ud: order.append(name) or outcomes[0], outcomes=outcomes)

    sequence = smach.Sequence(["succeeded", "aborted"], connector_outcome="succeeded")
    with sequence:
        smach.Sequence.add("A", state("A", "succeeded", "aborted"))
        smach.Sequence.add("B", state("B", "other", "succeeded"), {"other": "C"})
        smach.Sequence.add("C", state("C", "succeeded"))
    assert sequence.execute() == "succeeded"
    machine = smach.StateMachine(["done"])
    with machine:
        smach.StateMachine.add_auto("D", state("D", "x", "done"), ["x"])
        smach.StateMachine.add("E", state("E", "done"))
    assert machine.execute() == "done"
    assert order == ["A", "B", "C", "D", "E"]


def test_iterators(smach: Any) -> None:
    seen: list[int] = []

    @smach.cb_interface(input_keys=["index"], outcomes=["continue", "found"])
    def look(userdata: Any) -> str:
        seen.append(userdata.index)
        return "found" if userdata.index == wanted else "continue"

    def iterator(**options: Any) -> Any:
        result = smach.Iterator(
            ["succeeded", "gone"], [], [], it=lambda: range(4), it_label="index", exhausted_outcome="gone"
        )
        with result:
            smach.Iterator.set_contained_state("LOOK", smach.CBState(look), **options)
        return result

    wanted = 2
    mapped = iterator(loop_outcomes=["continue"], final_outcome_map={"found": "succeeded"})
    assert (mapped.execute(), seen) == ("succeeded", [0, 1, 2])
    wanted = 9
    assert mapped.execute() == "gone"
    assert iterator().execute() == "gone"
    wanted = 1
    assert iterator(break_outcomes=["found"], final_outcome_map={"found": "succeeded"}).execute() == "succeeded"
    assert mapped.get_children().keys() == {"LOOK"}
    assert ("continue", "LOOK", "LOOK") in mapped.get_internal_edges()


def test_concurrence(smach: Any) -> None:
    barrier = threading.Barrier(2, timeout=10)  # only passed if both run at once

    def both(userdata: Any, outcome: str) -> str:
        barrier.wait()
        userdata.out = outcome
        return outcome

    def run(left: str, right: str, **options: Any) -> Any:
        container = smach.Concurrence(["good", "bad", "other"], "other", output_keys=["l", "r"], **options)
        with container:
            for label, outcome, key in (("LEFT", left, "l"), ("RIGHT", right, "r")):
                state = smach.CBState(both, [outcome], outcomes=["yes", "no"], output_keys=["out"])
                smach.Concurrence.add(label, state, remapping={"out": key})
        parent = smach.UserData()
        outcome = container.execute(parent)
        assert (parent.l, parent.r) == (left, right)
        return outcome

    outcome_map = {"bad": {"LEFT": "no"}, "good": {"LEFT": "no", "RIGHT": "yes"}}
    assert run("no", "yes", outcome_map=outcome_map) == "good"
    assert run("no", "no", outcome_map=outcome_map) == "bad"
    assert run("yes", "no", outcome_map=outcome_map) == "other"
    assert run("yes", "no", outcome_cb=lambda each: "bad" if each["RIGHT"] == "no" else None) == "bad"


def waiting(smach: Any, services: bool = True) -> Any:
    """Return a state that waits until it is preempted."""

    class Waiting(smach.State):
        def __init__(self) -> None:
            smach.State.__init__(self, outcomes=["done", "preempted"])
            self.started = threading.Event()
            self.asked = threading.Event()

        def request_preempt(self) -> None:
            smach.State.request_preempt(self)
            self.asked.set()

        def execute(self, userdata: Any) -> str:
            self.started.set()
            assert self.asked.wait(10)
            self.asked.clear()
            if services:
                self.service_preempt()
            return "preempted"

    return Waiting()


def test_a_concurrence_preempts_the_others(smach: Any) -> None:
    container = smach.Concurrence(["done"], "done", child_termination_cb=lambda outcomes: outcomes["QUICK"] is not None)
    slow = waiting(smach)
    with container:
        smach.Concurrence.add("SLOW", slow)
        smach.Concurrence.add("QUICK", smach.CBState(lambda ud: slow.started.wait(10) and "done", outcomes=["done"]))
    assert container.execute() == "done"
    assert "Concurrent Outcomes: {'SLOW': 'preempted', 'QUICK': 'done'}" in smach.said
    assert not slow.preempt_requested() and not container.preempt_requested()


@pytest.mark.parametrize("services", [True, False])
def test_preemption_goes_to_the_state_that_runs(smach: Any, services: bool) -> None:
    """If it is not serviced there, it goes on to the next state."""
    first = waiting(smach, services)

    def next_one(userdata: Any) -> str:
        asked.append(last.preempt_requested())
        last.service_preempt()
        return "done"

    asked: list[bool] = []
    last = smach.CBState(next_one, outcomes=["done"])
    inner = smach.StateMachine(["done"])
    with inner:
        smach.StateMachine.add("FIRST", first, {"preempted": "LAST"})
        smach.StateMachine.add("LAST", last)
    top = smach.StateMachine(["done"])
    with top:
        smach.StateMachine.add("INNER", inner)
    results: list[Any] = []
    thread = threading.Thread(target=lambda: results.append(top.execute()))
    thread.start()
    assert first.started.wait(10) and top.is_running() and inner.get_active_states() == ["FIRST"]
    top.request_preempt()
    thread.join(10)
    assert (results, asked) == (["done"], [not services])
    assert not top.preempt_requested() and not inner.preempt_requested() and not top.is_running()


def test_the_end_of_the_program_ends_a_machine(smach: Any) -> None:
    ended: list[bool] = []
    smach.set_shutdown_check(lambda: bool(ended))
    top = smach.StateMachine(["never"])
    with top:
        inner = smach.StateMachine(["never"])
        with inner:
            loop = smach.CBState(lambda ud: ended.append(True) or "again", outcomes=["again"])
            smach.StateMachine.add("LOOP", loop, {"again": "LOOP"})
        smach.StateMachine.add("INNER", inner)
    assert top.execute() is None
    assert len(ended) == 1


def test_errors_of_construction(smach: Any) -> None:
    State, machine = smach.StateMachine, smach.StateMachine(["end"])
    done = smach.CBState(lambda ud: "done", outcomes=["done"])
    with pytest.raises(smach.InvalidStateError, match="open"):
        State.add("A", done)
    with machine:
        State.add("A", done, {"done": "NOWHERE"})
        with pytest.raises(smach.InvalidStateError, match="already"):
            State.add("A", done)
        with pytest.raises(smach.InvalidTransitionError, match="oops"):
            State.add("B", done, {"oops": "A"})
        with pytest.raises(smach.InvalidStateError, match="Concurrence"):
            smach.Concurrence.add("C", done)
    assert "NOWHERE" in "".join(smach.said)
    with pytest.raises(smach.InvalidTransitionError, match="NOWHERE"):
        machine.check_consistency()
    assert machine.execute() is None
    with pytest.raises(RuntimeError), smach.StateMachine(["end"]):
        raise RuntimeError
    with pytest.raises(smach.InvalidStateError):
        State.add("A", done)


def test_errors_of_states(smach: Any) -> None:
    def run(cb: Any, container: Any, add: Any) -> None:
        with container:
            add("A", smach.CBState(cb, outcomes=["done", "lost"]))
        container.execute()

    def fail(userdata: Any) -> str:
        raise ValueError("broken")

    add = smach.StateMachine.add
    with pytest.raises(smach.InvalidUserCodeError, match="broken"):
        run(fail, smach.StateMachine(["done"]), add)
    with pytest.raises(smach.InvalidTransitionError, match="registered outcomes"):
        run(lambda ud: "what", smach.StateMachine(["done"]), add)
    with pytest.raises(smach.InvalidTransitionError, match="neither a state nor an outcome"):
        run(lambda ud: "lost", smach.StateMachine(["done"]), add)
    with pytest.raises(smach.InvalidStateError, match="broken"):
        run(fail, smach.Concurrence(["done"], "done"), smach.Concurrence.add)


def test_a_missing_name_says_so(smach: Any) -> None:
    with pytest.raises(AttributeError, match=r"pyros1 has no smach\.AsyncState"):
        _ = smach.AsyncState


# As https://docs.ros.org/en/noetic/api/smach has them.
SIGNATURES = {
    "State": "outcomes input_keys output_keys io_keys",
    "CBState": "cb cb_args cb_kwargs outcomes input_keys output_keys io_keys",
    "Container": "outcomes input_keys output_keys",
    "StateMachine": "outcomes input_keys output_keys",
    "StateMachine.add": "label state transitions remapping",
    "StateMachine.add_auto": "label state connector_outcomes transitions remapping",
    "StateMachine.execute": "self parent_ud",
    "StateMachine.set_initial_state": "self initial_states userdata",
    "StateMachine.check_state_spec": "self label state transitions",
    "Concurrence": "outcomes default_outcome input_keys output_keys outcome_map outcome_cb child_termination_cb",
    "Concurrence.add": "label state remapping",
    "Sequence": "outcomes connector_outcome input_keys output_keys",
    "Sequence.add": "label state transitions remapping",
    "Iterator": "outcomes input_keys output_keys it it_label exhausted_outcome",
    "Iterator.set_contained_state": "label state loop_outcomes break_outcomes final_outcome_map",
    "Remapper": "ud input_keys output_keys remapping",
    "UserData.extract": "self keys remapping",
    "UserData.merge": "self ud keys remapping",
    "cb_interface": "outcomes input_keys output_keys",
    "CBInterface": "cb outcomes input_keys output_keys io_keys",
    "set_loggers": "info warn debug error",
    "set_shutdown_check": "cb",
    "has_smach_interface": "obj",
    "Container.register_start_cb": "self start_cb cb_args",
    "Container.register_transition_cb": "self transition_cb cb_args",
    "Container.register_termination_cb": "self termination_cb cb_args",
    "Container.call_termination_cbs": "self terminal_states outcome",
}


def test_signatures(smach: Any) -> None:
    for name, words in SIGNATURES.items():
        thing = smach
        for part in name.split("."):
            thing = getattr(thing, part)
        assert " ".join(inspect.signature(thing).parameters) == words, name
