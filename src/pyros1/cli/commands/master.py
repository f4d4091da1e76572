"""``pyros1 master``: runs only the master, without rosout, like rosmaster (L20). Most users want ``pyros1 core``."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import parse_without_specials
from pyros1.cli.records import Command, Flag, Option, Verb
from pyros1.cli.shared.integers import PORT_RANGE
from pyros1.cli.shared.listen_options import ALLOW_OPTION, BIND_OPTION, with_listen_options
from pyros1.ground.errors import Error

_BANNER = """ACHTUNG WARNING ACHTUNG WARNING ACHTUNG
This starts the master without rosout. Use pyros1 core (roscore) instead, or add --core if this is intended.
"""


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Run a master until a signal or a shutdown request arrives. Return the exit code, 1 if it could not start."""
    if args:
        raise UsageError(f"unrecognized args: {' '.join(args)}")

    from pyros1.ground.interrupts import install_handler  # noqa: PLC0415
    from pyros1.launch.running.core import LOG_LEVELS, Core  # noqa: PLC0415 - not needed for help
    from pyros1.launch.running.logs import log_folder  # noqa: PLC0415
    from pyros1.net.allowlist import make_allowlist  # noqa: PLC0415
    from pyros1.net.hosts import addresses_from_environment, make_uri, master_uri, parse_uri  # noqa: PLC0415
    from pyros1.net.signal_safe import POLL_INTERVAL  # noqa: PLC0415

    if options.port not in PORT_RANGE:
        raise UsageError(f"the port must be from 1 to 65535, not {options.port}")
    if options.level not in LOG_LEVELS:
        raise UsageError(f"the log level must be one of {', '.join(LOG_LEVELS)}, not {options.level!r}")
    if not options.core:
        print(_BANNER, flush=True)
    special_args = invocation.special
    environ = with_listen_options(os.environ, options)
    shutdown_requests: SimpleQueue[str] = SimpleQueue()  # safe in signal handlers
    # Installed before the master serves clients, which may shut it down immediately.
    restore_handlers = install_handler(lambda *_: shutdown_requests.put("signal"))
    try:
        port = options.port or parse_uri(master_uri(os.environ, special_args))[1]
        address = addresses_from_environment(environ, special_args)
        master_log_folder = Path(special_args["__log"]).parent if "__log" in special_args else log_folder(os.environ)
        master_log_folder.mkdir(parents=True, exist_ok=True)
        core = Core(
            port=port,
            address=address,
            uri=make_uri(address.advertised, port),
            log_folder=master_log_folder,
            environ=os.environ,
            on_shutdown=shutdown_requests.put,
            notify_timeout=options.timeout,
            log_level=options.level,
            allowlist=make_allowlist(address.allowed),
        )
        core.start_master()
        try:
            while True:
                # Without a timeout, a signal that arrives just before the wait would not end the wait.
                with suppress(Empty):
                    shutdown_requests.get(timeout=POLL_INTERVAL)
                    break
        finally:
            core.stop_master()
    except (Error, OSError) as error:
        print(f"ERROR: {error}", file=sys.stderr)
        return 1
    finally:
        restore_handlers()
    return 0


COMMAND = Command(
    "master",
    "start only a master, without rosout",
    Verb(
        "",
        "",
        Flag("--core", help="do not print the warning to use roscore"),
        Option("-p", "--port", metavar="PORT", dest="port", type="int", default=0, help="override port"),
        Option("-w", "--numworkers", metavar="NUM_WORKERS", type="int", help="accepted for compatibility; no effect"),
        Option(
            "-t",
            "--timeout",
            metavar="TIMEOUT",
            dest="timeout",
            type="float",
            help="seconds to wait for a node to respond",
        ),
        Option(
            "--master-logger-level",
            metavar="LEVEL",
            dest="level",
            default="info",
            help="lowest level written to the log",
        ),
        ALLOW_OPTION,
        BIND_OPTION,
        examples=[
            ("--core", "listen on the port of ROS_MASTER_URI, or 11311"),
            ("--core -p 11312 __log:=/tmp/master.log", "use another port, and write the log to /tmp"),
        ],
        stock_examples=True,
        parse=parse_without_specials,
        run=run,
    ),
    group="run",
    stock="rosmaster",
)
