"""A process that has already imported pyros1, and on each request forks a process that runs a Python program.

Fifty nodes would import the same modules fifty times, which takes most of their startup time. With ``--preload``, the
launcher starts this program; see `preloader` for its side. It has only one thread. The modules that it imports start no
threads, and depend only on the environment variables in `preloader.SHARED_VARIABLE_PREFIXES`. So a forked program
behaves as if started normally: with its own session, working directory, environment, arguments, output and
``__main__``.

A program must run at the top level of its process, so `prepare_interpreter` returns the code instead of running it.
"""

from __future__ import annotations

import builtins
import contextlib
import gc
import json
import os
import select
import signal
import socket
import struct
import sys
import time
import types
from importlib.util import find_spec
from typing import Any

LENGTH_FORMAT = struct.Struct("<I")
NUMBER_FORMAT = struct.Struct("<i")
"""A number sent to the launcher: a process id, or an exit code."""
_PRELOADED_MODULES = (
    "pyros1.node",
    "pyros1.msgs.std_msgs.msg",
    "pyros1.msgs.geometry_msgs.msg",
    "pyros1.msgs.sensor_msgs.msg",
)
_PRELOADED_ROSPY_MODULES = (
    "rospy",
    "std_msgs.msg",
    "std_srvs.srv",
    "geometry_msgs.msg",
    "sensor_msgs.msg",
    "nav_msgs.msg",
    "tf2_ros",
)
_OUR_MODULES = os.path.join("pyros1", "drop_in", "modules")


class Request:
    """A request to run a program in a forked process.

    Args:
        descriptors: the descriptors of the socket to the launcher, the standard output and the standard error. Over the
            socket, the launcher sends JSON with the script's path, arguments, environment and working directory.

    Raises:
        OSError, ValueError: the launcher has exited, or not all descriptors could be received.
    """

    def __init__(self, descriptors: list[int]) -> None:
        self.link, *self.outputs = descriptors
        if len(self.outputs) < 2:
            raise ValueError("not all descriptors were received")
        message = json.loads(read_message(self.link))
        self.script: str = message["script"]
        self.words: list[str] = message["words"]
        self.environ: dict[str, str] = message["environ"]
        self.working_directory: str = message["folder"]


def preload() -> None:
    """Import what most nodes import, including pyros1's rospy and related modules if this interpreter can find them."""
    import pyros1.node.node  # noqa: F401, PLC0415
    from pyros1.msgs import load_message  # noqa: PLC0415

    for name in _PRELOADED_MODULES:
        __import__(name)
    for name in ("rosgraph_msgs/Log", "rosgraph_msgs/Clock", "std_msgs/Float64", "std_msgs/String"):
        load_message(name)()
    rospy_spec = find_spec("rospy")
    if rospy_spec is None or _OUR_MODULES not in str(rospy_spec.origin):
        return
    for name in _PRELOADED_ROSPY_MODULES:
        with contextlib.suppress(ImportError):
            __import__(name)


def serve(control: socket.socket) -> Request | None:
    """Serve requests until the launcher has exited.

    Returns:
        In this process, None when the launcher has exited; in a forked process, the request for the program to run.
    """
    children: dict[int, socket.socket] = {}
    wake_receiver, wake_sender = socket.socketpair()
    for sock in (wake_receiver, wake_sender):
        sock.setblocking(False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.set_wakeup_fd(wake_sender.fileno(), warn_on_full_buffer=False)
    while True:
        readable, _, _ = select.select([control, wake_receiver], [], [])
        if wake_receiver in readable:
            wake_receiver.recv(4096)
            reap_children(children)
        if control not in readable:
            continue
        data, descriptors, _, _ = socket.recv_fds(control, 1, 3)
        if not data:
            signal.set_wakeup_fd(-1)
            for sock in (wake_receiver, wake_sender, *children.values()):
                sock.close()
            return None
        try:
            request = Request(descriptors)
            child = os.fork()
        except (OSError, ValueError):  # the launcher notices the failure, and starts the program in the usual way
            for descriptor in descriptors:
                os.close(descriptor)
            continue
        link = socket.socket(fileno=request.link)
        if not child:
            signal.set_wakeup_fd(-1)
            for sock in (control, wake_receiver, wake_sender, *children.values()):
                sock.close()
            await_start(link)
            return request
        for descriptor in request.outputs:
            os.close(descriptor)
        children[child] = link


def await_start(link: socket.socket) -> None:
    """Reset the signal handlers, report the process id to the launcher, and wait for the launcher's permission to
    continue; exit if the launcher exits first.
    """
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.setsid()
    send_number(link, os.getpid())
    permission = b""
    with link, contextlib.suppress(OSError):
        permission = link.recv(1)
    if not permission:
        os._exit(0)


def read_message(link: int) -> bytes:
    """Receive a message, which is preceded by its length.

    Raises:
        ConnectionError: the launcher exited before it had sent everything.
    """
    data = b""
    while len(data) < LENGTH_FORMAT.size or len(data) < LENGTH_FORMAT.size + LENGTH_FORMAT.unpack_from(data)[0]:
        chunk = os.read(link, 1 << 16)
        if not chunk:
            raise ConnectionError("the request is incomplete")
        data += chunk
    return data[LENGTH_FORMAT.size :]


def reap_children(children: dict[int, socket.socket]) -> None:
    """Reap programs that have exited, and report their exit codes to the launcher."""
    for child in list(children):
        pid, status = os.waitpid(child, os.WNOHANG)
        if pid:
            link = children.pop(pid)
            send_number(link, os.waitstatus_to_exitcode(status))
            link.close()


def send_number(link: socket.socket, number: int) -> None:
    """Send a number, unless the launcher has exited."""
    with contextlib.suppress(OSError):
        link.sendall(NUMBER_FORMAT.pack(number))


def prepare_interpreter(request: Request) -> tuple[Any, dict[str, Any]]:
    """Make this process look like a new interpreter that was started with a script.

    Returns:
        The script's code, and the namespace of its ``__main__``.

    Raises:
        OSError, SyntaxError: the script cannot be read.
    """
    for target, descriptor in enumerate(request.outputs, 1):
        os.dup2(descriptor, target)
        os.close(descriptor)
    os.environ.clear()
    os.environ.update(request.environ)
    os.chdir(request.working_directory)
    time.tzset()
    sys.argv = [request.script, *request.words]
    sys.orig_argv = [sys.executable, *sys.argv]
    if not getattr(sys.flags, "safe_path", False):  # new in Python 3.11
        sys.path.insert(0, os.path.dirname(os.path.realpath(request.script)))
    stdout: Any = sys.stdout
    stdout.reconfigure(line_buffering=os.isatty(1))
    main = types.ModuleType("__main__")
    main.__dict__.update(__file__=request.script, __builtins__=builtins)
    sys.modules["__main__"] = main
    hide_launcher_frames(request.script)
    with open(request.script, "rb") as file:
        return compile(file.read(), request.script, "exec", dont_inherit=True), main.__dict__


def hide_launcher_frames(script: str) -> None:
    """Make tracebacks start at the script, not at this module."""
    previous_hook = sys.excepthook

    def excepthook(
        error_type: type[BaseException], error: BaseException, traceback: types.TracebackType | None
    ) -> None:
        script_traceback = traceback
        while script_traceback is not None and script_traceback.tb_frame.f_code.co_filename != script:
            script_traceback = script_traceback.tb_next
        previous_hook(error_type, error.with_traceback(script_traceback), script_traceback)

    sys.excepthook = excepthook


def main(descriptor: int) -> tuple[Any, dict[str, Any]]:
    """Serve requests until the launcher exits; in a forked process, return the code and namespace of its program.

    Args:
        descriptor: descriptor of the socket to the launcher.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    preload()
    gc.collect()
    gc.freeze()  # so that garbage collections in the programs do not copy shared memory
    request = serve(socket.socket(fileno=descriptor))
    if request is None:
        sys.exit()
    return prepare_interpreter(request)
