"""``bridge router``: runs a standalone router, through which sites reach each other."""

from __future__ import annotations

import sys
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from pyros1.cli.commands.bridge._settings import (
    CONNECT_OPTION,
    INSECURE_FLAG,
    LISTEN_OPTION,
    SITES_OPTION,
    beside,
    check_connections,
    make_security,
    read_file,
    read_keys,
)
from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Flag, Option, Verb
from pyros1.ground.terminal_text import one_line

if TYPE_CHECKING:
    from collections.abc import Mapping

    from pyros1.bridge.rules.router_config import RouterConfig

_LOOK_PERIOD = 0.5
"""Seconds between checks of the connections."""


def run(invocation: Invocation, options: Any, args: list[str]) -> int | None:
    """Run the router until a signal arrives, or explain what it would do."""
    from pyros1.bridge.names import SiteNameError  # noqa: PLC0415
    from pyros1.bridge.rules.file_reader import RulesError  # noqa: PLC0415
    from pyros1.bridge.transport.certificates import KeysError  # noqa: PLC0415
    from pyros1.bridge.transport.endpoints import EndpointError  # noqa: PLC0415
    from pyros1.values.reading import YamlError  # noqa: PLC0415

    try:
        config = _read_config(options)
        if not config.listen:
            raise UsageError("give an endpoint to listen on with --listen, for example tls/[::]:7447")
        check_connections(config.connect, config.listen, config.keys, config.access, options.insecure, config.places)
        if options.check:
            from pyros1.bridge.rules.router_config import explain_router  # noqa: PLC0415

            print(*map(one_line, explain_router(config)), sep="\n")
            return None
        security: Mapping[str, str] = {}
        if config.keys:
            security = make_security(read_keys(config.keys), config.connect, config.listen, config.access)
    except (RulesError, SiteNameError, EndpointError, KeysError, YamlError) as error:
        raise CommandError(str(error), 2) from None
    return _run_router(config, security)


def _read_config(options: Any) -> RouterConfig:
    """Return the configuration from command line and file.

    Raises:
        RulesError, SiteNameError: the command line or the file is not valid.
    """
    from dataclasses import replace  # noqa: PLC0415

    from pyros1.bridge.rules.router_config import RouterConfig, parse_router_config  # noqa: PLC0415
    from pyros1.bridge.rules.site_access import add_names  # noqa: PLC0415

    config = RouterConfig()
    if options.config:
        config = parse_router_config(read_file(options.config), options.config)
        if config.keys:
            config = replace(config, keys=beside(config.keys, options.config))
    return replace(
        config,
        listen=(*config.listen, *options.listen),
        connect=(*config.connect, *options.connect),
        keys=options.keys or config.keys,
        access=add_names(config.access, [site for sites in options.sites for site in sites]),
    )


def _run_router(config: RouterConfig, security: Mapping[str, str]) -> int:
    from pyros1.bridge.transport.connections import Connections  # noqa: PLC0415
    from pyros1.bridge.transport.router import Router  # noqa: PLC0415
    from pyros1.ground.interrupts import install_handler  # noqa: PLC0415

    signals: SimpleQueue[int] = SimpleQueue()  # safe in signal handlers
    restore_handlers = install_handler(lambda number, _: signals.put(number))
    try:
        router = Router(config.connect, config.listen, security)
        try:
            print(f"router on {' and '.join(config.listen)}", flush=True)
            connections = Connections([each.keys for each in config.access] if config.keys else [])
            while True:
                for text, is_warning in connections.update(router.connections()):
                    start, stream = ("WARNING: ", sys.stderr) if is_warning else ("", sys.stdout)
                    print(start + one_line(text), file=stream, flush=True)
                try:
                    signals.get(timeout=_LOOK_PERIOD)
                except Empty:
                    continue
                return 0
        finally:
            router.close()
    finally:
        restore_handlers()


def _parse(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    from pyros1.cli.shared.argparsing import add_options_and_arguments, make_parser  # noqa: PLC0415

    parser = make_parser(invocation, verb)
    add_options_and_arguments(parser, invocation, *verb.options)
    return parser.parse_args(invocation.args), []


VERB = Verb(
    "router",
    "run a standalone router, through which sites reach each other",
    LISTEN_OPTION,
    CONNECT_OPTION,
    SITES_OPTION,
    Option("--config", metavar="FILE", help="YAML file with listen, to, keys, sites, and what each site may do"),
    Option("--keys", metavar="FOLDER", help="the router's keys, made by `pyros1 bridge keys`, for tls/ and quic/"),
    Flag("--check", help="explain what each site may do, and exit"),
    INSECURE_FLAG,
    description="Run a router on a server that all sites can reach: they connect to it, and reach each other through "
    "it. It needs neither a master nor a node. It prints who connects and disconnects.",
    examples=[
        ("--listen tls/[::]:7447 --keys router --sites red blue base", "a router for three sites"),
        ("--config fleet.yaml --check", "explain what each site may do"),
    ],
    stock="",
    parse=_parse,
    run=run,
)
