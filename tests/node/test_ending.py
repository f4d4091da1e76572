"""life: how a node ends: by the program, a callback, a hook or a signal (P03-P05); see also test_shutdown.py."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.ground.errors import MasterError, NodeShutdownError
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.node import Node
from pyros1.node.signals import SignalHandlers

from ..parts import context_of


def test_hooks_run_in_order_and_may_publish_p04_p05(make_node: Any, transport: str, collect: Any) -> None:
    got, order = collect(), []
    make_node("listener").subscribe("t", Float64, got)
    node = make_node("a")
    publisher = node.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    node.on_shutdown(lambda: order.append(("first", node.ok())))
    node.on_shutdown(lambda: publisher.publish(7))
    node.on_shutdown(lambda: order.append(("last", publisher.num_connections)))
    node.shutdown("test")
    got.wait()
    assert got.data == [7]
    assert order == [("first", False), ("last", 1)]


def test_early_hooks_run_while_all_works(make_node: Any) -> None:
    node, order = make_node("a"), []
    node.advertise_service("s", "std_srvs/Trigger", lambda _: (True, "served"))

    def early() -> None:
        answer = node.service("s", "std_srvs/Trigger")()
        order.append((node.ok(), node.sleep(0.01), answer.message))

    node.on_shutdown(lambda: order.append(node.ok()))
    node.on_shutdown(early, early=True)
    node.on_shutdown(lambda: 1 / 0, early=True)
    node.on_shutdown(lambda: order.append("last early"), early=True)
    node.shutdown()
    assert order == [(True, True, "served"), "last early", False]
    node.on_shutdown(lambda: order.append("at once"), early=True)
    assert order[-1] == "at once"


def test_a_bad_hook_stops_no_other(make_node: Any, capsys: Any) -> None:
    node, order = make_node("a"), []
    node.on_shutdown(lambda: 1 / 0)
    node.on_shutdown(lambda: order.append(1))
    node.shutdown()
    assert order == [1]
    err = capsys.readouterr().err
    assert "bad shutdown hook" in err and "ZeroDivisionError" in err


def test_a_hook_after_the_end_runs_at_once_p05(make_node: Any) -> None:
    node, order = make_node("a"), []
    node.shutdown()
    node.on_shutdown(lambda: order.append(1))
    assert order == [1]


def test_shutdown_happens_once_and_everybody_waits_for_it(make_node: Any, in_thread: Any) -> None:
    node, order, entered, leave = make_node("a"), [], threading.Event(), threading.Event()
    loop = context_of(node).loop

    def hook() -> None:
        order.append(1)
        entered.set()
        leave.wait(5)

    node.on_shutdown(hook)
    first = in_thread(node.shutdown)
    assert entered.wait(20)
    assert not node.ok()
    second = in_thread(node.shutdown)
    leave.set()
    first.join()
    second.join()
    node.shutdown()
    assert order == [1]
    assert not loop.thread.is_alive()


def test_shutdown_in_a_hook(make_node: Any) -> None:
    node = make_node("a")
    node.on_shutdown(node.shutdown)
    node.shutdown()
    assert not node.ok()


@pytest.mark.parametrize("callbacks", ["inline", "spin"])
def test_shutdown_in_a_callback(make_node: Any, transport: str, callbacks: str) -> None:
    node, other = make_node("a", callbacks=callbacks), make_node("b")
    node.subscribe("t", Float64, lambda message: node.shutdown())
    publisher = other.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(1)
    node.spin()
    node.shutdown()
    with pytest.raises(MasterError):
        other.master.lookup_node("/a")


def test_shutdown_in_a_service_handler_and_a_timer(make_node: Any) -> None:
    caller = make_node("caller")
    node = make_node("a")
    node.advertise_service("s", "std_srvs/Empty", lambda request: node.shutdown() or {})
    caller.service("s", "std_srvs/Empty")()
    node.spin()
    node.shutdown()
    node = make_node("b")
    node.timer(0.001, lambda event: node.shutdown())
    node.spin()
    node.shutdown()


def test_waits_of_the_program_end(make_node: Any, in_thread: Any) -> None:
    node = make_node("a")
    spinning, sleeping = in_thread(node.spin), in_thread(node.sleep, 30.0)
    node.shutdown()
    spinning.join()
    assert sleeping.join() is False
    spinner = make_node("b", callbacks="spin")
    spinning, once = in_thread(spinner.spin), in_thread(spinner.spin_once, 30.0)
    spinner.shutdown()
    spinning.join()
    assert once.join() == 0


def test_the_context_manager_swallows_only_the_end(environ: dict[str, str]) -> None:
    with Node("a", argv=[], environ=environ, handle_signals=False) as node:
        node.shutdown()
        node.wait_for_service("s")  # raises, because the node was told to stop: no news
    with pytest.raises(ZeroDivisionError), Node("b", argv=[], environ=environ, handle_signals=False) as node:
        raise ZeroDivisionError
    assert not node.ok()


def test_waits_in_callbacks_that_end_with_the_node_are_no_errors(
    make_node: Any, watch_log: Any, transport: str
) -> None:
    node, entered = make_node("a"), threading.Event()
    log = watch_log(node)

    def callback(message: Any) -> None:
        entered.set()
        node.wait_for_service("nothing")

    node.subscribe("t", Float64, callback)
    publisher = make_node("b").advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(1)
    assert entered.wait(20)
    node.shutdown()
    assert not [text for text in log.texts if "bad callback" in text]


def test_a_node_that_cannot_start_leaves_nothing(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> None:
        raise MasterError("no", 0)

    monkeypatch.setattr("pyros1.node.node.offer_log", refuse)
    with pytest.raises(MasterError):
        Node("a", argv=[], environ=environ, handle_signals=False)


def test_several_nodes_in_one_process_end_on_their_own(make_node: Any) -> None:
    a, b = make_node("a"), make_node("b")
    a.shutdown()
    assert b.ok() and not a.ok()
    b.advertise("t", Float64)
    with pytest.raises(NodeShutdownError):
        a.advertise("t", Float64)


def test_signal_handlers_are_put_back(environ: dict[str, str]) -> None:
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    with Node("a", argv=[], environ=environ):
        assert signal.getsignal(signal.SIGINT) != before[0]
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before


def test_outside_the_main_thread_no_signals_are_handled(environ: dict[str, str], in_thread: Any) -> None:
    before = signal.getsignal(signal.SIGINT)
    node = in_thread(lambda: Node("a", argv=[], environ=environ)).join()
    assert signal.getsignal(signal.SIGINT) == before
    node.shutdown()


# Signal handlers ------------------------------------------------------------------------------------------------------


@pytest.fixture
def handlers(monkeypatch: pytest.MonkeyPatch) -> Callable[[Any], tuple[SignalHandlers, list[Any]]]:
    """Return a function that sets the program's handlers and installs a node's; each signal counts, however soon."""
    monkeypatch.setattr("pyros1.ground.interrupts.MIN_REPEAT_INTERVAL", 0.0)

    def install(program: Any) -> tuple[SignalHandlers, list[Any]]:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, program)
        ended: list[Any] = []
        handlers = SignalHandlers(ended.append)
        handlers.install()
        return handlers, ended

    return install


@pytest.mark.parametrize("program", [signal.SIG_DFL, signal.default_int_handler], ids=["system", "python"])
@pytest.mark.parametrize(
    ("number", "error"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, SystemExit)], ids=["int", "term"]
)
def test_the_first_signal_ends_the_node_and_the_second_the_program(
    handlers: Any, program: Any, number: int, error: type[BaseException]
) -> None:
    installed, ended = handlers(program)
    signal.raise_signal(number)
    assert ended == [number] and installed.count == 1
    with pytest.raises(error) as caught:
        signal.raise_signal(number)
    assert ended == [number]
    if error is SystemExit:
        assert caught.value.code == 128 + signal.SIGTERM


def test_signals_in_quick_succession_are_one(handlers: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """As from a terminal and a launcher: nobody has pressed Ctrl-C twice."""
    installed, ended = handlers(signal.default_int_handler)
    monkeypatch.setattr("pyros1.ground.interrupts.MIN_REPEAT_INTERVAL", 1000.0)
    for _ in range(3):
        signal.raise_signal(signal.SIGINT)
    assert ended == [signal.SIGINT] and installed.count == 1


def test_the_programs_own_handler_gets_each_signal_before_the_node_ends(handlers: Any) -> None:
    order: list[Any] = []
    _, ended = handlers(lambda number, frame: order.append((number, list(ended))))
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.raise_signal(number)
    assert order == [(signal.SIGINT, []), (signal.SIGTERM, [signal.SIGINT])]
    assert ended == [signal.SIGINT]


def test_a_programs_handler_that_raises_ends_the_node_all_the_same(handlers: Any) -> None:
    _, ended = handlers(lambda number, frame: 1 // 0)
    for _ in range(2):
        with pytest.raises(ZeroDivisionError):
            signal.raise_signal(signal.SIGINT)
    assert ended == [signal.SIGINT]


def test_after_the_end_the_next_signal_is_the_programs(handlers: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A signal that comes at once, as from a terminal and a launcher, is passed over: it means the same."""
    got: list[int] = []

    def program(number: int, frame: Any) -> None:
        got.append(number)

    installed, ended = handlers(program)
    signal.raise_signal(signal.SIGINT)
    installed.restore()
    assert signal.getsignal(signal.SIGINT) not in (program, signal.SIG_DFL)
    with monkeypatch.context() as patch:
        patch.setattr("pyros1.ground.interrupts.MIN_REPEAT_INTERVAL", 1000.0)
        signal.raise_signal(signal.SIGINT)
    assert (got, ended) == ([signal.SIGINT], [signal.SIGINT])
    signal.raise_signal(signal.SIGINT)
    assert (got, ended) == ([signal.SIGINT] * 2, [signal.SIGINT])
    assert signal.getsignal(signal.SIGINT) is program


def test_a_signal_of_a_forked_process_does_not_end_the_node(make_node: Any) -> None:
    """It ends the process, as if there were no node; or the program's loop, if its own handler was called."""
    if not hasattr(os, "fork"):
        pytest.skip("no fork here")
    node = make_node("a", handle_signals=True)
    child = os.fork()
    if child == 0:
        signal.raise_signal(signal.SIGTERM)
        os._exit(7)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGTERM
    assert node.ok()
