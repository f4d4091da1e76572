from __future__ import annotations

import random
from typing import Any

from pyros1.msgs.bond.msg import Status
from pyros1.robot_nodes.shared.bond import Bond, State


def status(instance: str, active: bool = True, id: str = "arm") -> Status:
    return Status(id=id, instance_id=instance, active=active)


def state_of(bond: Bond) -> State:
    return bond.state


def formed() -> Bond:
    bond = Bond("arm", "me", 0.0)
    bond.receive(status("you"), 1.0)
    assert state_of(bond) is State.ALIVE
    return bond


def test_nobody_answers() -> None:
    bond = Bond("arm", "me", 0.0)
    for other in (status("me"), status("you", id="leg"), status("you", active=False), status("")):
        bond.receive(other, 1.0)
    sent = [bond.tick(now / 10) for now in range(0, 99)]
    assert sum(each is not None and each.active for each in sent) == 10 and state_of(bond) is State.WAITING
    last = bond.tick(10.0)
    assert last is not None and not last.active and state_of(bond) is State.BROKEN
    assert bond.tick(100.0) is None


def test_the_other_side_falls_silent() -> None:
    bond = formed()
    bond.receive(status("third", active=False), 2.0)
    bond.receive(status("you"), 3.0)
    bond.tick(6.9)
    assert state_of(bond) is State.ALIVE
    bond.receive(status("third"), 6.9)
    last = bond.tick(7.0)
    assert state_of(bond) is State.BROKEN and last is not None and not last.active


def test_the_other_side_ends_it() -> None:
    bond = formed()
    bond.tick(1.0)
    bond.receive(status("you", active=False), 1.5)
    confirmation = bond.tick(1.5)
    assert state_of(bond) is State.BROKEN and confirmation is not None and not confirmation.active


def test_this_side_ends_it_and_repeats_that_until_it_is_confirmed() -> None:
    bond = formed()
    bond.end(2.0)
    assert [bond.tick(2.0 + step / 100) is not None for step in range(0, 12)].count(True) == 3
    assert state_of(bond) is State.ENDING
    bond.receive(status("you", active=False), 2.2)
    assert state_of(bond) is State.BROKEN
    alone = formed()
    alone.end(2.0)
    alone.tick(4.0)
    assert state_of(alone) is State.BROKEN, "nobody confirms it"


def test_two_sides_agree_whatever_is_lost_or_late() -> None:
    for seed in range(60):
        chance = random.Random(seed)
        loss = chance.choice([0.0, 0.3])
        bonds = [Bond("arm", name, 0.0) for name in ("a", "b")]
        end = chance.choice([None, 4.0, 30.0])
        flying: list[tuple[float, int, Any]] = []
        seen = set()
        for step in range(600):
            now = step * 0.1
            if end is not None and now == end:
                bonds[0].end(now)
            for number, bond in enumerate(bonds):
                sent = bond.tick(now)
                if sent is not None and chance.random() >= loss:
                    flying.append((now + chance.random() * 0.3, 1 - number, sent))
            for item in [item for item in flying if item[0] <= now]:
                flying.remove(item)
                bonds[item[1]].receive(item[2], now)
            seen.add((bonds[0].state, bonds[1].state))
        assert (State.ALIVE, State.ALIVE) in seen, seed
        if end is not None:
            assert {bond.state for bond in bonds} == {State.BROKEN}, seed
        elif not loss:
            assert {bond.state for bond in bonds} == {State.ALIVE}, seed
