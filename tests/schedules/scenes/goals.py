"""Actions: goals of several clients, their cancelling and their results, while topics overtake each other, links break,
and the server ends.

Each goal ends exactly once in its client, with its own result, and each wait ends. The server publishes one result of
each goal; where no link breaks, the client says the same of it as the server.
"""

from __future__ import annotations

from collections import Counter
from contextlib import ExitStack
from typing import Any

from pyros1.actions import ActionError, Client, ClientGoal, GoalError, Server, ServerGoal, SimpleServer, Status
from pyros1.actions import Stage as GoalStage
from pyros1.msgs.actionlib_tutorials.msg import FibonacciAction, FibonacciFeedback, FibonacciGoal, FibonacciResult

from ..stage import Scenario, Stage
from .board import Board, Station

CLIENTS, GOALS = 2, 2
PATIENCE = 60.0
WORK = 30e-6
"""Seconds for one step of a goal's work."""


class Sent:
    """A goal, and what its client heard of it."""

    def __init__(self, client: Client, order: int) -> None:
        self.order = order
        self.stages: list[GoalStage] = []
        self.heard: list[int] = []
        self.ends: list[ClientGoal] = []
        self.goal = client.send(
            FibonacciGoal(order=order),
            on_feedback=lambda feedback: self.heard.append(feedback.sequence[0]),
            on_stage=lambda _, stage: self.stages.append(stage),
            on_done=self.ends.append,
            timeout=PATIENCE,
        )


class Goals(Scenario):
    """Clients send goals to a server that works on all at once; one cancels its own, which end in no other way, another
    one those of all.
    """

    modules = tuple(
        f"pyros1.actions.{name}"
        for name in (
            *("client", "client_goal", "progress", "callback_thread"),
            *("server", "server_goal", "goal_table", "simple_server", "goal_id"),
        )
    )
    limits: tuple[tuple[str, str, Any], ...] = (
        ("pyros1.actions.client", "LOST_AFTER", 0.05),
        ("pyros1.actions.progress", "LOST_AFTER", 0.05),
    )
    breaks = False

    def play(self, stage: Stage) -> None:
        """Play it."""
        board = Board(stage)
        self.sent: list[Sent] = []
        self.over = False
        with ExitStack() as stack:
            self.serve(stage, board, stack)
            clients = [
                stack.enter_context(Client(_node(board, f"/client{number}"), "act", FibonacciAction))
                for number in range(CLIENTS)
            ]
            stage.together(*self.jobs(stage, board, clients))
            results = self.results(board)
            stage.until(lambda: all(each.ends for each in self.sent), PATIENCE)
            self.over = True
        board.close()
        self.check(results)
        odd = [text for text in stage.told if "goal" in text]
        assert self.breaks or not odd, odd

    def jobs(self, stage: Stage, board: Board, clients: list[Client]) -> list[Any]:
        """Return what happens at the same time."""

        def ask(number: int) -> Any:
            def job() -> None:
                client = clients[number]
                mine = []
                for order in range(1, GOALS + 1):
                    mine.append(Sent(client, 10 * number + order))
                    self.sent.append(mine[-1])
                    if number == 1:
                        mine[-1].goal.cancel()
                for sent in mine:
                    self.hear(sent)

            return job

        def cancel_all() -> None:
            stage.until(lambda: self.sent)
            clients[0].cancel_all()

        return [*(ask(number) for number in range(CLIENTS)), cancel_all]

    def hear(self, sent: Sent) -> None:
        """Wait for the end of a goal; look at its result."""
        try:
            result = sent.goal.result(PATIENCE)
        except GoalError as error:
            assert error.status is sent.goal.status
            return
        assert result.sequence == (sent.order,), f"{result} is of another goal than {sent.order}"

    def serve(self, stage: Stage, board: Board, stack: ExitStack) -> None:
        """Start the server."""

        def begin(goal: ServerGoal) -> None:
            board.threads += stage.spawn(lambda: work(goal))

        def work(goal: ServerGoal) -> None:
            try:
                goal.accept()
                goal.feedback(FibonacciFeedback(sequence=[goal.goal.order]))
                stage.time.sleep(WORK)
                if goal.goal.order > 10:  # the client will cancel it
                    stage.until(lambda: goal.cancel_requested or goal.ended or self.over, 2 * PATIENCE)
                if goal.cancel_requested:
                    goal.cancel(FibonacciResult(sequence=[goal.goal.order]))
                elif goal.goal.order % 10 == 1:
                    goal.succeed(FibonacciResult(sequence=[goal.goal.order]))
                else:
                    goal.abort(FibonacciResult(sequence=[goal.goal.order]))
            except ActionError:
                assert goal.ended, f"nobody ends it: {goal.status}"

        def end_early(goal: ServerGoal) -> None:
            try:
                goal.cancel()
            except ActionError:
                assert goal.ended

        node: Any = Station(board, "/server")
        stack.enter_context(Server(node, "act", FibonacciAction, begin, end_early, frequency=100.0, kept=0.2))

    def results(self, board: Board) -> list[Any]:
        """Return what the server has published as results; it is appended to."""
        return next(each for each in board.publishers if each.name == "/act/result").sent

    def check(self, results: list[Any]) -> None:
        """Compare what clients and server say of the goals."""
        by_name = {result.status.goal_id.id: Status(result.status.status) for result in results}
        count = Counter(result.status.goal_id.id for result in results)
        assert not count or max(count.values()) == 1, f"several results of one goal: {count}"
        for sent in self.sent:
            goal = sent.goal
            assert sent.ends == [goal] and goal.done, f"{goal.name} ended {len(sent.ends)} times"
            assert sent.stages[-1] is GoalStage.DONE and sent.stages.count(GoalStage.DONE) == 1, sent.stages
            assert set(sent.heard) <= {sent.order}
            assert goal.status.ended, goal.status
            if not self.breaks:
                assert goal.status is by_name[goal.name], f"{goal.name}: {goal.status}, {by_name[goal.name]}"
            elif goal.status is not Status.LOST:
                assert goal.status is by_name[goal.name]


class SimpleGoals(Goals):
    """The server works on the newest goal only."""

    def serve(self, stage: Stage, board: Board, stack: ExitStack) -> None:
        """Start the server."""

        def execute(goal: ServerGoal) -> Any:
            for _ in range(3):
                goal.feedback(FibonacciFeedback(sequence=[goal.goal.order]))
                stage.time.sleep(WORK)
                if goal.cancel_requested:
                    goal.cancel(FibonacciResult(sequence=[goal.goal.order]))
                    return None
            return FibonacciResult(sequence=[goal.goal.order])

        node: Any = Station(board, "/server")
        stack.enter_context(SimpleServer(node, "act", FibonacciAction, execute, frequency=100.0, kept=0.2))


class LostLinks(Goals):
    """All links break, and what is on its way is lost; they come again, soon or late."""

    breaks = True

    def jobs(self, stage: Stage, board: Board, clients: list[Client]) -> list[Any]:
        """Return what happens at the same time."""

        def cut() -> None:
            stage.until(lambda: self.sent)
            board.cut()
            stage.time.sleep(20e-6)
            board.mend()

        return [*super().jobs(stage, board, clients), cut]


class LostServer(LostLinks):
    """All links break, for longer than a client has patience."""

    def jobs(self, stage: Stage, board: Board, clients: list[Client]) -> list[Any]:
        """Return what happens at the same time."""

        def cut() -> None:
            stage.until(lambda: len(self.sent) == CLIENTS * GOALS)
            board.cut()
            stage.until(lambda: all(each.ends for each in self.sent), PATIENCE)

        return [*Goals.jobs(self, stage, board, clients), cut]


class Leaving(Goals):
    """Clients are closed while goals are open: waits for these end."""

    breaks = True

    def jobs(self, stage: Stage, board: Board, clients: list[Client]) -> list[Any]:
        """Return what happens at the same time."""

        def post() -> None:
            stage.until(lambda: len(self.sent) == CLIENTS * GOALS)
            clients[0].close()

        return [*super().jobs(stage, board, clients), post]


def _node(board: Board, name: str) -> Any:
    return Station(board, name)
