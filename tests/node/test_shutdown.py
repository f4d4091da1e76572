"""life: how a node ends: by the program, a callback, the master, a signal or the interpreter (P03-P05)."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import pyros1
from pyros1.ground.errors import MasterError, NodeShutdownError
from pyros1.ground.interrupts import MIN_REPEAT_INTERVAL
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.node import Node

from ..parts import context_of

SRC = str(Path(pyros1.__file__).parent.parent)


def test_hooks_run_in_order_and_may_publish_p04_p05(make_node: Any, transport: str, collect: Any) -> None:
    got, order = collect(), []
    make_node("listener").subscribe("t", Float64, got)
    node = make_node("a")
    publisher = node.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=5)
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
    assert entered.wait(5)
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
    assert publisher.wait_for_subscribers(timeout=5)
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
    assert publisher.wait_for_subscribers(timeout=5)
    publisher.publish(1)
    assert entered.wait(5)
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


# In a process of their own --------------------------------------------------------------------------------------------


class Program:
    """A child process. Its pipes are unbuffered: what one read does not want is left for the next."""

    def __init__(self, text: str, environ: dict[str, str]) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-u", "-W", "error", "-c", "import pyros1\n" + textwrap.dedent(text)],
            env={**os.environ, **environ, "PYTHONPATH": SRC},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            bufsize=0,
        )

    def line(self, stream: str = "stdout") -> str:
        """Read a line."""
        line: bytes = getattr(self.process, stream).readline()
        return line.decode()

    def end(self) -> tuple[int, str, str]:
        """Wait for the end; return exit code and the rest of the output."""
        out, err = self.process.communicate(timeout=20)
        return self.process.returncode, out.decode(), err.decode()


@pytest.fixture
def program(environ: dict[str, str]) -> Iterator[Any]:
    """Return a function that runs a program, up to the line ``ready``."""
    children: list[Program] = []

    def run(text: str) -> Program:
        child = Program(text, environ)
        children.append(child)
        line = child.line()
        assert line == "ready\n", f"{line!r} {child.end()}"
        return child

    yield run
    for child in children:
        if child.process.poll() is None:
            child.process.kill()
        child.process.communicate()


LOOP = """
    with pyros1.Node("looper") as node:
        node.on_shutdown(lambda: print("hook"))
        rate = node.rate(1000)
        print("ready")
        while node.ok():
            rate.sleep()
    print("left")
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_usual_loop_cleanly(program: Any, make_node: Any, number: int) -> None:
    observer = make_node("observer")
    child = program(LOOP)
    assert observer.master.lookup_node("/looper")
    child.process.send_signal(number)
    assert child.end() == (0, "hook\nleft\n", "")
    with pytest.raises(MasterError):
        observer.master.lookup_node("/looper")


@pytest.mark.parametrize("wait", ["node.spin()", "node.sleep(100)", "node.wait_for_service('nothing')"])
@pytest.mark.parametrize("callbacks", ["inline", "spin"])
def test_ctrl_c_ends_every_wait_of_the_node(program: Any, wait: str, callbacks: str) -> None:
    child = program(
        f"""
        with pyros1.Node("waiter", callbacks="{callbacks}") as node:
            node.timer(0.001, lambda event: None)
            print("ready")
            {wait}
        """
    )
    child.process.send_signal(signal.SIGINT)
    assert child.end() == (0, "", "")


def test_a_second_ctrl_c_interrupts_the_program(program: Any, make_node: Any) -> None:
    child = program(
        """
        import time
        with pyros1.Node("busy") as node:
            node.on_shutdown(lambda: print("hook"))
            print("ready")
            while True:
                time.sleep(0.01)  # takes no notice of the node's end
        """
    )
    child.process.send_signal(signal.SIGINT)
    assert child.line() == "hook\n"
    child.process.send_signal(signal.SIGINT)
    time.sleep(MIN_REPEAT_INTERVAL)  # no person is quicker; what came at once did not count
    assert child.process.poll() is None
    child.process.send_signal(signal.SIGINT)
    code, _, err = child.end()
    assert code in (1, -signal.SIGINT)
    assert "KeyboardInterrupt" in err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_second_signal_in_a_long_end_after_the_program_ends_the_process_without_a_traceback(
    program: Any, make_node: Any, number: int
) -> None:
    child = program(
        """
        import threading
        node = pyros1.Node("slow")
        node.on_shutdown(lambda: (print("hook"), threading.Event().wait(10)))
        print("ready")
        node.spin()
        """
    )
    child.process.send_signal(number)
    assert child.line() == "hook\n"
    time.sleep(MIN_REPEAT_INTERVAL)  # no person is quicker
    child.process.send_signal(number)
    assert child.end() == (-number, "", "")


def test_the_end_of_the_program_ends_its_nodes(program: Any, make_node: Any) -> None:
    observer = make_node("observer")
    child = program(
        """
        node = pyros1.Node("forgetful")
        node.advertise("t", "std_msgs/Float64")
        node.on_shutdown(lambda: print("hook"))
        print("ready")
        """
    )
    assert child.end() == (0, "hook\n", "")
    with pytest.raises(MasterError):
        observer.master.lookup_node("/forgetful")


def test_an_exception_ends_the_node_and_is_shown(program: Any, make_node: Any) -> None:
    observer = make_node("observer")
    child = program(
        """
        with pyros1.Node("failing") as node:
            print("ready")
            raise RuntimeError("out of order")
        """
    )
    code, _, err = child.end()
    assert code == 1 and "RuntimeError: out of order" in err
    with pytest.raises(MasterError):
        observer.master.lookup_node("/failing")


def test_ctrl_c_while_waiting_for_the_master_ends_the_program(program: Any, free_port: int) -> None:
    child = program(
        f"""
        import sys
        print("ready")
        with pyros1.Node("early", master_uri="http://localhost:{free_port}/") as node:
            print("never")
        """
    )
    assert "Unable to immediately register" in child.line("stderr")
    child.process.send_signal(signal.SIGINT)
    code, out, _ = child.end()
    assert code != 0 and out == ""


def test_ctrl_c_while_the_master_is_asked_ends_the_program(program: Any) -> None:
    child = program(
        """
        import signal, threading
        import pyros1.node.node as starting
        ask, ended = starting.set_private, threading.Event()

        def interrupted(master, *others):
            close = master.close
            master.close = lambda: (close(), ended.set())
            signal.raise_signal(signal.SIGINT)
            assert ended.wait(10)
            return ask(master, *others)

        starting.set_private = interrupted
        print("ready")
        with pyros1.Node("early") as node:
            print("never")
        """
    )
    assert child.end() == (130, "", "")


def test_the_master_ends_a_node_of_another_process_m34(program: Any, make_node: Any) -> None:
    child = program(LOOP)
    make_node("looper")
    code, out, err = child.end()
    assert (code, out) == (0, "hook\nleft\n")
    assert "shutdown request: [/looper] Reason: new node registered with same name" in err


FORKING = """
import os, signal, sys
import pyros1

node = pyros1.Node("parent", argv=[])
child = os.fork()
if not child:
    sys.exit(0)
assert os.waitpid(child, 0)[1] == 0
ready, tell = os.pipe()
child = os.fork()
if not child:
    os.write(tell, b"x")
    while True:
        signal.pause()
os.read(ready, 1)
os.kill(child, signal.SIGTERM)
assert os.WTERMSIG(os.waitpid(child, 0)[1]) == signal.SIGTERM
assert node.ok()
publisher = node.advertise("t", "std_msgs/Float64", latch=True)
publisher.publish(7)
assert publisher.wait_for_subscribers(timeout=10)
node.spin()
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_what_a_forked_process_can_do_with_the_node(program: Any) -> None:
    assert program(CHILD).end() == (0, "7 3 3\n7 3 3 NodeError NodeError NodeError\n7\n", "")


CHILD = """
import os, sys, threading
import pyros1

def attempt(action):
    try:
        return type(action()).__name__
    except pyros1.Error as error:
        assert "was forked" in str(error)
        return type(error).__name__

with pyros1.Node("parent", argv=[]) as node:
    node.params["p"] = 7
    node.advertise_service("s", "std_srvs/SetBool", lambda request: (request.data, "3"))
    call = node.service("s", "std_srvs/SetBool", persistent=True)
    publisher = node.advertise("t", "std_msgs/Float64")
    subscriber = node.subscribe("t", "std_msgs/Float64", print)
    call(True)
    ended = threading.Event()
    def ask():
        while not ended.is_set():
            node.params["p"]
    asking = [threading.Thread(target=ask) for _ in range(3)]  # they have the client's lock when the process is forked
    for thread in asking:
        thread.start()
    print("ready", flush=True)
    for makes in (False, True):
        child = os.fork()
        if not child:
            words = [node.params["p"], call(True).message, call(False).message]
            if makes:
                words += [
                    attempt(lambda: node.advertise("u", "std_msgs/Float64")),
                    attempt(lambda: node.wait_for_message("t", "std_msgs/Float64", timeout=30)),
                    attempt(lambda: node.advertise_service("v", "std_srvs/Empty", lambda request: {})),
                ]
                publisher.unregister()
                subscriber.unregister()
            print(*words, flush=True)
            os._exit(0)
        assert os.waitpid(child, 0)[1] == 0
    ended.set()
    for thread in asking:
        thread.join()
    call(True)  # on its connection
    call.close()
    print(node.params["p"])
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_processes_forked_from_a_node_leave_it_alone(make_node: Any, collect: Any) -> None:
    listener, got = make_node("listener"), collect()
    listener.subscribe("/t", "std_msgs/Float64", got)
    environ = {**os.environ, **listener.environ, "PYTHONPATH": SRC}
    with subprocess.Popen([sys.executable, "-c", FORKING], env=environ) as program:
        try:
            got.wait(1)
        finally:
            program.terminate()
    assert got.data == [7]
