"""Random machines of smach by pyros1, against a plain program that follows the same transitions."""

from __future__ import annotations

import random
import threading
from collections.abc import Iterator
from typing import Any, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from smach_modules import imported


class Tree(NamedTuple):
    """A state, or a container with its children; each has the outcomes a and b.

    Attributes:
        kind: "leaf", "machine", "sequence", "iterator".
        children: of a container.
        targets: of a machine: for each child, where a and b lead: a child's index, or an outcome.
        count: of an iterator: items.
    """

    kind: str
    children: tuple[Tree, ...] = ()
    targets: tuple[tuple[Any, Any], ...] = ()
    count: int = 0


@st.composite
def machines(draw: Any, children: Any) -> Tree:
    some = tuple(draw(st.lists(children, min_size=1, max_size=4)))
    target = st.sampled_from([*range(len(some)), "a", "b"])
    return Tree("machine", some, tuple((draw(target), draw(target)) for _ in some))


def containers(children: Any) -> Any:
    some = st.lists(children, min_size=1, max_size=3).map(tuple)
    iterators = st.tuples(children, st.integers(1, 3)).map(lambda each: Tree("iterator", (each[0],), (), each[1]))
    return machines(children) | some.map(lambda each: Tree("sequence", each)) | iterators


TREES = containers(st.recursive(st.just(Tree("leaf")), containers, max_leaves=8))


class Script:
    """What the leaves return, one after the other; when it is over, the program ends."""

    def __init__(self, words: list[str]) -> None:
        self.words = list(words)
        self.trace: list[tuple[str, int]] = []

    @property
    def over(self) -> bool:
        return not self.words

    def next(self, path: str, value: int) -> tuple[str, int]:
        self.trace.append((path, value))
        word = self.words.pop(0)
        return word, 3 * value + (word == "a")


def follow(tree: Tree, script: Script, value: int, path: str = "") -> tuple[str | None, int]:
    """Return outcome and value of a tree; no outcome if the program ends before."""
    if tree.kind == "leaf":
        return script.next(path, value)
    begin, index, left = value, 0, tree.count
    while True:
        if tree.kind == "iterator":
            if not left:
                return "a", value
            left -= 1
        if script.over:
            return None, begin
        outcome, value = follow(tree.children[index], script, value, f"{path}/{index}")
        if outcome is None:
            return None, begin
        if tree.kind == "machine":
            target = tree.targets[index][outcome == "b"]
        elif outcome == "b" or (tree.kind == "sequence" and index == len(tree.children) - 1):
            target = outcome
        else:
            target = index + (tree.kind == "sequence")
        if isinstance(target, str):
            return target, value
        index = target


def build(smach: Any, tree: Tree, script: Script, path: str = "") -> Any:
    """Return the same as states of smach; ``x`` is the value's name in each."""
    if tree.kind == "leaf":

        def leaf(userdata: Any) -> str:
            word, userdata.x = script.next(path, userdata.x)
            return word

        return smach.CBState(leaf, outcomes=["a", "b"], io_keys=["x"])
    children = [build(smach, child, script, f"{path}/{index}") for index, child in enumerate(tree.children)]
    if tree.kind == "iterator":
        iterator = smach.Iterator(["a", "b"], ["x"], ["x"], it=range(tree.count), exhausted_outcome="a")
        with iterator:
            smach.Iterator.set_contained_state("0", children[0], loop_outcomes=["a"])
        return iterator
    if tree.kind == "sequence":
        sequence = smach.Sequence(["a", "b"], "a", ["x"], ["x"])
        with sequence:
            for index, child in enumerate(children):
                smach.Sequence.add(str(index), child)
        return sequence
    machine = smach.StateMachine(["a", "b"], ["v"], ["v"])  # under another name
    with machine:
        for index, child in enumerate(children):
            targets = dict(zip("ab", map(str, tree.targets[index]), strict=True))
            smach.StateMachine.add(str(index), child, targets, {"x": "v"})
    outer = smach.StateMachine(["a", "b"], ["x"], ["x"])
    with outer:
        smach.StateMachine.add("M", machine, remapping={"v": "x"})
    return outer


@pytest.fixture(scope="module")
def smach() -> Iterator[Any]:
    with imported("smach") as module:
        module.set_loggers(*([lambda text: None] * 4))
        yield module


@pytest.mark.slow
@settings(max_examples=150, deadline=None)
@given(tree=TREES, words=st.lists(st.sampled_from("ab"), min_size=1, max_size=40))
def test_machines_do_as_a_plain_program(smach: Any, tree: Tree, words: list[str]) -> None:
    plain, ours = Script(words), Script(words)
    top = build(smach, tree, ours)
    smach.set_shutdown_check(lambda: ours.over)
    data = smach.UserData()
    data.x = 1
    assert (top.execute(data), data.x) == follow(tree, plain, 1)
    assert ours.trace == plain.trace


def looping(smach: Any, chance: random.Random, depth: int) -> Any:
    """Return a state, or a container of some, that ends with "next", or with "preempted" if it serviced that."""
    kind = chance.choice(["machine", "concurrence", "iterator"]) if depth else "state"
    if kind == "state":
        state = smach.State(["next", "preempted"])

        def execute(userdata: Any) -> str:
            for _ in range(chance.randrange(3)):
                if state.preempt_requested():
                    state.service_preempt()
                    return "preempted"
            return "next"

        state.execute = execute
        return state
    if kind == "machine":
        machine = smach.StateMachine(["next", "preempted"])
        with machine:
            smach.StateMachine.add("0", looping(smach, chance, depth - 1), {"next": "1"})
            smach.StateMachine.add("1", looping(smach, chance, depth - 1))
        return machine
    if kind == "concurrence":
        both = smach.Concurrence(
            ["next", "preempted"], "next", outcome_cb=lambda each: "preempted" if "preempted" in each.values() else None
        )
        with both:
            for label in "01":
                smach.Concurrence.add(label, looping(smach, chance, depth - 1))
        return both
    iterator = smach.Iterator(["next", "preempted"], [], [], it=range(2), exhausted_outcome="next")
    with iterator:
        state = looping(smach, chance, depth - 1)
        smach.Iterator.set_contained_state("0", state, loop_outcomes=["next"])
    return iterator


def below(smach: Any, state: Any) -> Iterator[Any]:
    """Return all states in a container."""
    if isinstance(state, smach.Container):
        for child in state.get_children().values():
            yield child
            yield from below(smach, child)


@pytest.mark.slow
def test_no_preemption_is_lost(smach: Any) -> None:
    """Whenever it comes, it ends a machine that would go on for ever, and leaves nothing in its states."""
    smach.set_shutdown_check(lambda: False)
    for seed in range(150):
        chance = random.Random(seed)
        top = smach.StateMachine(["preempted"])
        with top:
            smach.StateMachine.add("LOOP", looping(smach, chance, 3), {"next": "LOOP"})
        started, outcomes = threading.Event(), []
        top.register_start_cb(lambda userdata, labels, started=started: started.set())
        thread = threading.Thread(target=lambda top=top, outcomes=outcomes: outcomes.append(top.execute()), daemon=True)
        thread.start()
        assert started.wait(10)
        for _ in range(seed * 20):
            pass  # a moment, of which there are many
        top.request_preempt()
        thread.join(10)
        assert outcomes == ["preempted"], seed
        assert not any(state.preempt_requested() for state in below(smach, top)), seed
