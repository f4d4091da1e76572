"""life: how nodes of other processes end: by a signal, the interpreter, the master, or after a fork (P03-P05)."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import pyros1
from pyros1.ground.errors import MasterError
from pyros1.ground.interrupts import MIN_REPEAT_INTERVAL

SRC = str(Path(pyros1.__file__).parent.parent)


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
