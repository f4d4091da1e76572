"""The parameters of rosbridge_websocket (no I/O). See https://wiki.ros.org/rosbridge_server."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pyros1.ground.errors import Error
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.web.rosbridge.frame_decoder import MAX_FRAME

_DEFAULT_PING_INTERVAL = 20.0
"""Default number of seconds between pings. By default, the original sends none, and keeps dead connections for hours.
"""
_MAX_SECONDS = 86_400.0


class UnsupportedError(Error):
    """A parameter requires something unsupported, so the server must not start; the message says what to do."""


@dataclass(frozen=True)
class Settings:
    """The parameters of rosbridge_websocket.

    Attributes:
        port: the port to listen on; 0 for any free port.
        address: the address to listen on.
        retry_delay: seconds after which the server tries again to listen if the port is in use.
        certificate, key: files with the certificate and its private key; empty for connections without TLS.
        compresses: whether WebSocket frames are compressed for clients that offer it.
        max_message_size: maximum size in bytes of a client's frame.
        ping_interval: seconds between pings.
        ping_timeout: seconds after which a client that does not answer a ping is disconnected.
        allows_null_origin: whether pages without an origin, such as those opened from a file, may connect.
        topics, services, parameters: patterns for what clients may use; empty for all.
    """

    port: int = 9090
    address: str = "0.0.0.0"
    retry_delay: float = 2.0
    certificate: str = ""
    key: str = ""
    compresses: bool = False
    max_message_size: int = MAX_FRAME
    ping_interval: float = _DEFAULT_PING_INTERVAL
    ping_timeout: float = 30.0
    allows_null_origin: bool = True
    topics: tuple[str, ...] = ()
    services: tuple[str, ...] = ()
    parameters: tuple[str, ...] = ()


def read_settings(parameters: PrivateParameters) -> Settings:
    """Read the parameters.

    Raises:
        UnsupportedError: the parameters require rosauth or BSON, or name only one of the two files for TLS. A server
            that ignored this would admit clients that it must not, or none at all.
    """
    if parameters.flag("authenticate", False):
        raise UnsupportedError(
            "the parameter authenticate is not supported, so this server does not start: remove it, and restrict "
            "access with PYROS1_ALLOW, or use `pyros1 web`, whose links contain a token"
        )
    if parameters.flag("bson_only_mode", False):
        raise UnsupportedError(
            "the parameter bson_only_mode is not supported: clients can send JSON, and receive JSON or CBOR"
        )
    certificate, key = parameters.text("certfile", ""), parameters.text("keyfile", "")
    if bool(certificate) != bool(key):
        raise UnsupportedError("the parameters certfile and keyfile must both be set (for TLS), or neither")
    max_size = MAX_FRAME
    if parameters.value("max_message_size") != "None":
        max_size = parameters.integer("max_message_size", MAX_FRAME, 1)
    return Settings(
        port=parameters.integer("port", Settings.port, 0, 65535),
        address=parameters.text("address", Settings.address) or Settings.address,
        retry_delay=parameters.number("retry_startup_delay", Settings.retry_delay, 0.0, _MAX_SECONDS),
        certificate=certificate,
        key=key,
        compresses=parameters.flag("use_compression", False),
        max_message_size=min(max_size, MAX_FRAME),
        ping_interval=parameters.number("websocket_ping_interval", 0.0, 0.0, _MAX_SECONDS) or _DEFAULT_PING_INTERVAL,
        ping_timeout=parameters.number("websocket_ping_timeout", Settings.ping_timeout, 0.0, _MAX_SECONDS)
        or Settings.ping_timeout,
        allows_null_origin=parameters.flag("websocket_null_origin", True),
        topics=read_patterns(parameters, "topics_glob"),
        services=read_patterns(parameters, "services_glob"),
        parameters=read_patterns(parameters, "params_glob"),
    )


def read_patterns(parameters: PrivateParameters, name: str) -> tuple[str, ...]:
    """Return the patterns in a parameter such as ``['/camera/*', /odom]``; none if it is empty, which allows all names.

    Raises:
        UnsupportedError: the parameter is not a list of patterns. A server that ignored it would show everything.
    """
    value: Any = parameters.value(name)
    if isinstance(value, list) and all(isinstance(pattern, str) for pattern in value):  # already parsed as YAML
        return tuple(value)
    if value is None or value == "":
        return ()
    if not isinstance(value, str) or value[0] + value[-1] != "[]":
        raise UnsupportedError(f"the parameter {name} must be a list of patterns such as [/camera/*, /odom]")
    patterns = (pattern.strip().strip("'\"") for pattern in value[1:-1].split(","))
    return tuple(pattern for pattern in patterns if pattern)


def options_in(args: Sequence[str]) -> dict[str, Any]:
    """Return the parameters that are set by command-line options such as ``--port 9091``.

    Args:
        args: the command line without the program's name and remappings.

    Raises:
        UnsupportedError: an option has no value.
    """
    options: dict[str, Any] = {}
    remaining = iter(args)
    for arg in remaining:
        if not arg.startswith("--"):
            continue
        if arg == "--bson_only_mode":
            options["bson_only_mode"] = True
            continue
        value = next(remaining, None)
        if value is None:
            raise UnsupportedError(f"{arg} needs a value")
        options[arg[2:]] = _parse(value)
    return options


def _parse(text: str) -> str | int | float:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
