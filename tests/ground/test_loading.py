"""Blocks that only load modules."""

from __future__ import annotations

import gc

from pyros1.ground.loading import loading


def test_what_a_block_made_is_old_at_its_end() -> None:
    with loading():
        assert not gc.isenabled()
        made = [[number] for number in range(3000)]
    assert gc.isenabled() and not gc.get_freeze_count()
    young = {id(each) for generation in (0, 1) for each in gc.get_objects(generation)}
    assert not young & set(map(id, made))


def test_what_a_program_has_frozen_stays_so() -> None:
    gc.freeze()
    try:
        with loading():
            pass
        assert gc.get_freeze_count()
    finally:
        gc.unfreeze()
