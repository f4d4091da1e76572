"""The names of rospy's modules, and how they are called: ours beside stock's."""

from __future__ import annotations

import functools
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from faces import START
from harness import SOURCE, STOCK_PYTHON

HERE = Path(__file__).parent
MODULES = [
    "rospy",
    *(
        "rospy." + name
        for name in ["client", "core", "exceptions", "msg", "msproxy", "names", "numpy_msg", "rostime", "service"]
    ),
    *("rospy." + name for name in ["timer", "topics", "logger_level_service_caller"]),
    *("rospy.impl." + name for name in ["paramserver", "tcpros_base", "tcpros_service"]),
]
LACKING = {
    "rospy.client": set(),
    "rospy.core": {
        "NullHandler",
        "configure_logging",
        "deprecated",
        "reload_mappings",
        "set_initialized",
        "set_node_uri",
    },
    "rospy.names": {"reload_mappings"},
    "rospy.rostime": {"get_rostime_cond"},
    "rospy.service": {"DeadTransport", "ProtocolHandler", "get_registration_listeners", "logger"},
    "rospy.topics": {
        *("Poller", "QueuedConnection", "SubscriberStatisticsLogger", "get_registration_listeners"),
        *("get_tcpros_handler", "python3", "set_topic_manager", "set_service_manager"),
    },
    "rospy.impl.paramserver": {"GLOBALNS", "SEP", "ParamServerCache.set", "ParamServerCache.set_notifier"},
    "rospy.impl.tcpros_base": {
        *("DeserializationError", "EAGAIN", "EWOULDBLOCK", "TCPROSServer", "TCPServer", "get_tcpros_server_address"),
        *("init_tcpros_server", "logger", "python3", "read_ros_handshake_header", "recv_buff", "start_tcpros_server"),
        *("write_ros_handshake_header", "TCPROSTransport.receive_loop", "TCPROSTransport.set_socket"),
        *("TCPROSTransportProtocol.read_messages", "deserialize_messages", "serialize_message"),
    },
    "rospy.impl.tcpros_service": {
        *("TCPService", "get_service_manager", "get_tcpros_server_address", "logger", "recv_buff"),
        *(
            "service_connection_handler",
            "start_tcpros_server",
            "TCPROSServiceClient.read_messages",
            "logdebug",
            "loginfo",
        ),
        *("TCPROSTransport.receive_loop", "TCPROSTransport.set_socket", "TCPROSTransportProtocol.read_messages"),
        *("TransportInitError", "TransportTerminated"),
    },
}
"""What ours do not have: the inside of stock's connections and registrations, and what its modules only import."""


@functools.cache
def found(script: str, face: str) -> dict[str, dict[str, Any]]:
    """Return what a script says of all modules."""
    stock = face == "stock"
    environ = {**os.environ, "PYTHONPATH": "" if stock else f"{START}:{SOURCE}"}
    command = [STOCK_PYTHON if stock else sys.executable, str(HERE / script), *MODULES]
    done = subprocess.run(command, env=environ, capture_output=True, text=True, timeout=60, check=True)
    answer: dict[str, dict[str, Any]] = json.loads(done.stdout)
    return answer


@pytest.mark.parametrize("module", MODULES)
def test_names(module: str) -> None:
    ours, stock = (found("surface.py", face)[module] for face in ("ours", "stock"))
    lacking = LACKING.get(module, set()) | set().union(*LACKING.values())
    missing = {name for name in stock if name not in ours and name not in lacking and name.split(".")[0] not in lacking}
    assert not missing


@pytest.mark.parametrize("module", MODULES)
def test_parameters(module: str) -> None:
    ours, stock = (found("signatures.py", face)[module] for face in ("ours", "stock"))
    both = [name for name in stock if name in ours and not name.startswith(("AnyMsg.", "Message."))]
    assert both or module == "rospy.exceptions"
    wrong = {name: (ours[name], stock[name]) for name in both if not _takes(ours[name], stock[name])}
    assert not wrong


def _takes(ours: list[Any], stock: list[Any]) -> bool:
    """Tell whether ours can be called as stock's: more parameters are allowed if they have defaults."""
    if ours[: len(stock)] == stock:
        return all(optional or kind.startswith("VAR") for _, kind, optional in ours[len(stock) :])
    return any(kind == "VAR_POSITIONAL" for _, kind, _ in ours) and any(kind == "VAR_KEYWORD" for _, kind, _ in ours)
