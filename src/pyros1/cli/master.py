"""``pyros1 master``: the master alone, without rosout, as stock's rosmaster (L20); people want ``pyros1 core``."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from queue import SimpleQueue

from pyros1.cli.usage import Parser
from pyros1.errors import Error
from pyros1.names import parse_arguments

_EXAMPLES = {
    "%prog --core": "listen on the port of ROS_MASTER_URI, or 11311",
    "%prog --core -p 11312 __log:=/tmp/master.log": "on another port, with its log there",
}
_BANNER = """ACHTUNG WARNING ACHTUNG WARNING ACHTUNG
The master alone has no rosout: start it with pyros1 core (roscore), or say --core if that is meant.
"""


def main(argv: list[str]) -> int:
    """Run ``pyros1 master`` until a signal, or a client of its API, ends it.

    Args:
        argv: the words after the command's name.

    Returns:
        The exit code: 0 after a normal end, 1 when it could not start, 2 for a wrong command line.
    """
    special = parse_arguments(argv).special
    parser = Parser("rosmaster", "%prog [options]", _EXAMPLES)
    add = parser.add_option
    add("--core", action="store_true", dest="core", default=False, help="do not ask whether roscore was meant")
    add("-p", "--port", metavar="PORT", dest="port", type="int", default=0, help="override port")
    add("-w", "--numworkers", metavar="NUM_WORKERS", type="int", help="accepted; no workers needed")
    add("-t", "--timeout", metavar="TIMEOUT", dest="timeout", type="float", help="seconds that nodes have to answer")
    add("--master-logger-level", metavar="LEVEL", dest="level", default="info", help="least level in the log")
    options, words = parser.parse_args([word for word in argv if not word.startswith("__")])
    if words:
        parser.error(f"unrecognized args: {' '.join(words)}")

    from pyros1.interrupts import catch  # noqa: PLC0415
    from pyros1.launch.core import LOG_LEVELS, Core  # noqa: PLC0415 - after the command line proved right
    from pyros1.launch.logs import log_folder  # noqa: PLC0415
    from pyros1.net.hosts import host_from_environment, master_uri, parse_uri  # noqa: PLC0415

    if options.level not in LOG_LEVELS:
        parser.error(f"the level must be one of {', '.join(LOG_LEVELS)}, not {options.level!r}")
    if not options.core:
        print(_BANNER, flush=True)
    ended: SimpleQueue[str] = SimpleQueue()  # a signal handler may put into it
    restore = catch(lambda *_: ended.put("signal"))  # before it answers: who sees that may end it
    try:
        port = options.port or parse_uri(master_uri(os.environ, special))[1]
        address = host_from_environment(os.environ, special)
        folder = Path(special["__log"]).parent if "__log" in special else log_folder(os.environ)
        folder.mkdir(parents=True, exist_ok=True)
        core = Core(
            port=port,
            address=address,
            uri=f"http://{address.advertised}:{port}/",
            log_folder=folder,
            environ=os.environ,
            on_shutdown=ended.put,
            notify_timeout=options.timeout,
            log_level=options.level,
        )
        core.start_master()
        try:
            ended.get()
        finally:
            core.stop_master()
    except (Error, OSError) as error:
        print(f"ERROR: {error}", file=sys.stderr)
        return 1
    finally:
        restore()
    return 0
