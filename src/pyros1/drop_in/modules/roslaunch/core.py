"""The parts of a launch (nodes, machines and parameters), and roslaunch's print functions."""

from __future__ import annotations

import functools
import getpass
import os
import socket
import uuid
from collections.abc import Callable, Mapping
from typing import Any, TypeVar
from xmlrpc.client import MultiCall, ServerProxy

from rosgraph.network import create_local_xmlrpc_uri, parse_http_host_and_port

from pyros1.ground.errors import LaunchError
from pyros1.net.hosts import is_local
from roslaunch.nodes import TEST_TIME_LIMIT_DEFAULT, Node, Param, Test
from roslaunch.printing import (
    add_printerrlog_handler,
    add_printlog_handler,
    clear_printerrlog_handlers,
    clear_printlog_handlers,
    is_child_mode,
    printerrlog,
    printlog,
    printlog_bold,
    set_child_mode,
)

DEFAULT_MASTER_PORT = 11311
PHASE_SETUP = "setup"
PHASE_RUN = "run"
PHASE_TEARDOWN = "teardown"
_F = TypeVar("_F", bound=Callable[..., Any])


__all__ = [
    "PHASE_RUN",
    "PHASE_SETUP",
    "PHASE_TEARDOWN",
    "TEST_TIME_LIMIT_DEFAULT",
    "Executable",
    "Machine",
    "Master",
    "MultiCall",
    "Node",
    "Param",
    "RLException",
    "RosbinExecutable",
    "ServerProxy",
    "Test",
    "add_printerrlog_handler",
    "add_printlog_handler",
    "clear_printerrlog_handlers",
    "clear_printlog_handlers",
    "generate_run_id",
    "get_master_uri_env",
    "get_ros_package_path",
    "get_ros_root",
    "is_child_mode",
    "is_machine_local",
    "local_machine",
    "printerrlog",
    "printlog",
    "printlog_bold",
    "remap_localhost_uri",
    "rl_errors",
    "rle_wrapper",
    "set_child_mode",
    "setup_env",
]


class RLException(Exception):
    """Something cannot be launched."""


def rl_errors(function: _F) -> _F:
    """Make a function raise RLException instead of pyros1's LaunchError."""

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        try:
            return function(*args, **kwargs)
        except LaunchError as error:
            raise RLException(str(error)) from error

    return call  # type: ignore[return-value]


def rle_wrapper(fn: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap a function of positional arguments so that any exception becomes an RLException with its message."""

    def wrapped_fn(*args: Any) -> Any:
        try:
            return fn(*args)
        except Exception as error:
            raise RLException(f"ERROR: {error}") from error

    return wrapped_fn


# Environment and addresses --------------------------------------------------------------------------------------------


def generate_run_id() -> str:
    """Return a new run id."""
    return str(uuid.uuid1())


def get_ros_root() -> str | None:
    """Return the environment variable ROS_ROOT."""
    return os.environ.get("ROS_ROOT")


def get_ros_package_path() -> str | None:
    """Return the environment variable ROS_PACKAGE_PATH."""
    return os.environ.get("ROS_PACKAGE_PATH")


def get_master_uri_env() -> str:
    """Return the master's URI from the environment."""
    return os.environ.get("ROS_MASTER_URI", f"http://localhost:{DEFAULT_MASTER_PORT}/")


def remap_localhost_uri(uri: str, force_localhost: bool = False) -> str:
    """Replace "localhost" in a URI with the name by which other machines reach this one.

    Args:
        uri: an address.
        force_localhost: whether to treat the address as this machine's, whatever its host is.

    Raises:
        ValueError: ``uri`` is not an address.
    """
    host, port = parse_http_host_and_port(uri)
    return create_local_xmlrpc_uri(port) if force_localhost or host == "localhost" else uri


class Master:
    """The master of a launch.

    Attributes:
        type: "rosmaster".
        uri: the master's address.
        auto: not used.
    """

    ROSMASTER = "rosmaster"
    ZENMASTER = "zenmaster"
    __slots__ = ["auto", "type", "uri"]

    def __init__(self, type_: str | None = None, uri: str | None = None, auto: Any = None) -> None:
        self.auto = None  # as in stock ROS, where the attribute is no longer used
        self.type = type_ or Master.ROSMASTER
        self.uri = uri or get_master_uri_env()

    def get_host(self) -> str:
        """Return the host in the master's URI; raise ValueError if there is none."""
        return str(parse_http_host_and_port(self.uri)[0])

    def get_port(self) -> int:
        """Return the port in the master's URI; raise ValueError if there is none."""
        return int(parse_http_host_and_port(self.uri)[1])

    def __eq__(self, m2: object) -> bool:
        return isinstance(m2, Master) and (self.type, self.uri) == (m2.type, m2.uri)

    def __hash__(self) -> int:
        return hash((self.type, self.uri))

    def get(self) -> ServerProxy:
        """Return an ``xmlrpc.client.ServerProxy`` for the master."""
        return ServerProxy(self.uri)

    def get_multi(self) -> MultiCall:
        """Return an ``xmlrpc.client.MultiCall`` for the master."""
        return MultiCall(self.get())

    def is_running(self) -> bool:
        """Return whether the master responds."""
        try:
            master: Any = self.get()
            master.getPid("/roslaunch")
        except OSError:
            return False
        return True


class Machine:
    """A machine that can run nodes.

    Attributes:
        name, address, env_loader, ssh_port, user, password, assignable, timeout: as in a <machine> tag.
    """

    __slots__ = ["address", "assignable", "env_loader", "name", "password", "ssh_port", "timeout", "user"]

    def __init__(
        self,
        name: str,
        address: str,
        env_loader: str | None = None,
        ssh_port: int = 22,
        user: str | None = None,
        password: str | None = None,
        assignable: bool = True,
        env_args: Any = (),
        timeout: float | None = None,
    ) -> None:
        self.name = name
        self.address = address
        self.env_loader = env_loader
        self.ssh_port = ssh_port
        self.user = user or None
        self.password = password
        self.assignable = assignable
        self.timeout = timeout or 10.0

    def config_key(self) -> str:
        """Return a string that is the same for machines that can share one connection."""
        return (
            f"Machine(address[{self.address}] env_loader[{self.env_loader}] ssh_port[{self.ssh_port}] "
            f"user[{self.user or ''}] password[{self.password or ''}] timeout[{self.timeout}])"
        )

    def config_equals(self, m2: Any) -> bool:
        """Return whether another machine has the same settings; the names may differ."""
        return isinstance(m2, Machine) and self.config_key() == m2.config_key()

    def __eq__(self, m2: object) -> bool:
        return (
            isinstance(m2, Machine)
            and (self.name, self.assignable) == (m2.name, m2.assignable)
            and self.config_equals(m2)
        )

    def __ne__(self, m2: object) -> bool:
        return not self == m2

    def __hash__(self) -> int:
        return hash(self.config_key())

    def __str__(self) -> str:
        return (
            f"Machine(name[{self.name}] env_loader[{self.env_loader}] address[{self.address}] "
            f"ssh_port[{self.ssh_port}] user[{self.user}] assignable[{self.assignable}] timeout[{self.timeout}])"
        )


class Executable:
    """A command to run in addition to the nodes; pyros1 stores it, but does not run it."""

    def __init__(self, cmd: str, args: Any, phase: str = PHASE_RUN) -> None:
        self.command = cmd
        self.args = args
        self.phase = phase

    def __repr__(self) -> str:
        return f"{self.command} {' '.join(self.args)}"

    __str__ = __repr__


class RosbinExecutable(Executable):
    """A command of ROS itself."""

    def __repr__(self) -> str:
        return f"ros/bin/{super().__repr__()}"

    __str__ = __repr__


def local_machine() -> Machine:
    """Return the Machine for this machine."""
    return _LOCAL_MACHINE


_LOCAL_MACHINE = Machine("", "localhost")


def is_machine_local(machine: Any) -> bool:
    """Return whether a machine is this one, with nodes running as the same user.

    Raises:
        RLException: the machine's address is unknown.
    """
    address = machine.address
    same_user = machine.user in (None, getpass.getuser())
    if address is None:
        return same_user
    try:
        socket.getaddrinfo(address, None)
    except OSError as error:
        raise RLException(f"cannot resolve host address for machine [{address}]") from error
    return is_local(address) and same_user


def setup_env(node: Any, machine: Any, master_uri: str, env: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return the environment variables of a node.

    Args:
        node: the Node; None for no node.
        machine: not used.
        master_uri: the master's address.
        env: the environment to extend; None for this process's.
    """
    result = dict(os.environ if env is None else env)
    result["ROS_MASTER_URI"] = master_uri
    if node is not None:
        namespace = node.namespace.rstrip("/")
        result.pop("ROS_NAMESPACE", None)
        if namespace:
            result["ROS_NAMESPACE"] = namespace
        result.update(node.env_args)
    return result
