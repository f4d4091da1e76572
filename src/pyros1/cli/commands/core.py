"""``pyros1 core``: runs the master, the parameter server and rosout (L06-L19, https://wiki.ros.org/roscore)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import default_options, parse_without_specials
from pyros1.cli.records import Command, Flag, Option, Verb
from pyros1.cli.shared.listen_options import ALLOW_OPTION, BIND_OPTION, PORTS_OPTION, with_listen_options


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Run a core until a signal arrives. Return the exit code, which is 1 if the master could not be started."""
    if args:
        raise UsageError(f"{invocation.program} does not take arguments")

    from pyros1.cli.commands.launch import VERB as LAUNCH_VERB  # noqa: PLC0415 - not needed for help
    from pyros1.cli.shared.launching import launch, print_exception  # noqa: PLC0415
    from pyros1.ground.errors import Error  # noqa: PLC0415
    from pyros1.launch.plan import Plan  # noqa: PLC0415
    from pyros1.launch.reading.system_resources import make_resources  # noqa: PLC0415

    launch_options = default_options(LAUNCH_VERB)
    launch_options.core = True
    launch_options.port = options.port
    launch_options.timeout = options.timeout
    launch_options.master_logger_level = options.level
    launch_options.no_journal = options.no_journal
    if options.sigint_timeout is not None:
        launch_options.sigint_timeout = options.sigint_timeout
    if options.sigterm_timeout is not None:
        launch_options.sigterm_timeout = options.sigterm_timeout
    try:
        resources = make_resources()
        resources = replace(resources, environ=with_listen_options(resources.environ, options))
        return launch(Plan(), launch_options, resources, title="roscore")
    except Error as error:
        print_exception(error)
        return 1


COMMAND = Command(
    "core",
    "start a master with a parameter server and rosout",
    Verb(
        "",
        "",
        Option(
            "-p",
            "--port",
            metavar="PORT",
            dest="port",
            type="int",
            help="master port. Only valid if master is launched",
        ),
        Flag("-v", dest="verbose", help="verbose printing"),
        Option(
            "-w",
            "--numworkers",
            metavar="NUM_WORKERS",
            dest="num_workers",
            type="int",
            help="accepted for compatibility; no effect",
        ),
        Option(
            "-t",
            "--timeout",
            metavar="TIMEOUT",
            dest="timeout",
            type="float",
            help="seconds the master waits for a node to respond",
        ),
        Option(
            "--master-logger-level",
            metavar="LEVEL",
            dest="level",
            default="",
            help="lowest level written to master.log",
        ),
        Option(
            "--sigint-timeout",
            metavar="SECONDS",
            dest="sigint_timeout",
            type="float",
            help="seconds from SIGINT to SIGTERM",
        ),
        Option(
            "--sigterm-timeout",
            metavar="SECONDS",
            dest="sigterm_timeout",
            type="float",
            help="seconds from SIGTERM to SIGKILL",
        ),
        Flag(
            "--no-journal",
            dest="no_journal",
            help="do not restore the state of a core that was killed",
        ),
        ALLOW_OPTION,
        BIND_OPTION,
        PORTS_OPTION,
        examples=[
            ("", "listen on the port of ROS_MASTER_URI, or 11311"),
            ("-p 11312", "listen on another port"),
            ("--allow 192.168.1.0/24", "accept connections only from this network and from this machine"),
            ("--sigint-timeout 1", "wait one second for processes that ignore Ctrl-C"),
        ],
        stock_examples=True,
        parse=parse_without_specials,
        run=run,
    ),
    group="run",
    stock="roscore",
)
