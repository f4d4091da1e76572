"""Blocks that only load modules."""

from __future__ import annotations

import gc

from pyros1.ground.loading import loading


def test_what_a_block_made_is_old_at_its_end() -> None:
    frozen = gc.get_freeze_count()  # Python 3.12 itself has frozen some, which stay so
    with loading():
        assert not gc.isenabled()
        made = [[number] for number in range(3000)]
    assert gc.isenabled() and gc.get_freeze_count() == frozen
    young = {id(each) for generation in (0, 1) for each in gc.get_objects(generation)}
    assert bool(young & set(map(id, made))) == bool(frozen)


def test_what_a_program_has_frozen_stays_so() -> None:
    gc.freeze()
    try:
        with loading():
            pass
        assert gc.get_freeze_count()
    finally:
        gc.unfreeze()
