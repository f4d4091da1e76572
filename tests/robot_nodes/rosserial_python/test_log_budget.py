from __future__ import annotations

from pyros1.robot_nodes.rosserial_python.log_budget import BURST, RATE, LogBudget


def test_a_board_that_logs_little_may_do_so_for_ever() -> None:
    budget = LogBudget(5.0)
    assert all(budget.allows(5.0 + line / RATE) for line in range(5 * BURST)) and budget.take_dropped() == 0


def test_of_a_flood_some_lines_are_written_and_the_others_counted() -> None:
    budget = LogBudget(0.0)
    assert sum(budget.allows(0.0) for _ in range(10_000)) == BURST
    assert sum(budget.allows(1.0 + line / 1e6) for line in range(1000)) == 1, "one warning for many lines"
    budget = LogBudget(0.0)
    written = dropped = 0
    for line in range(100_000):
        if budget.allows(line / 1000):
            dropped += budget.take_dropped()
            written += 1
    assert written + dropped + budget.num_dropped == 100_000
    assert written <= BURST + 100 * RATE
