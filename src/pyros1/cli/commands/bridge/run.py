"""``bridge run``: runs the bridge of a site."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.cli.commands.bridge._plugin import OPTIONS, run_plugin, wants_plugin
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
    from pyros1.bridge.rules.parsing import SiteConfig


def run(invocation: Invocation, options: Any, args: list[str]) -> int | None:
    """Run the bridge until its node shuts down, or explain what it would do."""
    from pyros1.bridge.names import SiteNameError  # noqa: PLC0415
    from pyros1.bridge.rules.file_reader import RulesError  # noqa: PLC0415
    from pyros1.bridge.rules.unknown_sites import unknown_sites  # noqa: PLC0415
    from pyros1.bridge.transport.certificates import KeysError  # noqa: PLC0415
    from pyros1.bridge.transport.endpoints import EndpointError  # noqa: PLC0415
    from pyros1.values.reading import YamlError  # noqa: PLC0415

    try:
        if wants_plugin(options):
            return run_plugin(invocation, options)
        if options.namespace or options.old_keys:
            raise UsageError("--namespace and --old-keys need --dialect zenoh-plugin-ros1")
        config = _read_config(options)
        check_connections(
            config.connect, config.listen, config.keys, config.rules.access, options.insecure, config.places
        )
        _warn(unknown_sites(config.rules))
        security = {} if options.check else _read_keys(config)
    except (RulesError, SiteNameError, EndpointError, KeysError, YamlError) as error:
        raise CommandError(str(error), 2) from None
    if options.check:
        from pyros1.bridge.rules.explanation import explain  # noqa: PLC0415

        print(*map(one_line, explain(config)), sep="\n")
        try:
            _read_keys(config)
        except KeysError as error:  # the file may be written on a machine without keys
            _warn([str(error)])
        return None
    if not config.connect and not config.listen:
        raise UsageError("give the endpoint of another site with --to, or one to listen on with --listen")
    return _run_bridge(invocation, config, security)


def _warn(warnings: Iterable[str]) -> None:
    for warning in warnings:
        print(f"WARNING: {warning}", file=sys.stderr)


def _read_config(options: Any) -> SiteConfig:
    """Return the configuration from command line and file.

    Raises:
        RulesError, SiteNameError: the command line or the file is not valid.
    """
    from dataclasses import replace  # noqa: PLC0415

    from pyros1.bridge.rules.parsing import (  # noqa: PLC0415
        SiteConfig,
        add_arguments,
        check_loss,
        parse_config,
        rules_from_arguments,
    )
    from pyros1.bridge.rules.service_parsing import add_service_words  # noqa: PLC0415
    from pyros1.bridge.rules.site_access import add_names, named_sites  # noqa: PLC0415

    send = [word for words in options.send for word in words]
    take = [word for words in options.take for word in words]
    if options.config:
        config = add_arguments(parse_config(read_file(options.config), options.config, options.site or ""), send, take)
        if config.keys:
            config = replace(config, keys=beside(config.keys, options.config))
    elif not options.site:
        raise UsageError("name this site with --site, or give a file with --config")
    else:
        config = SiteConfig(rules_from_arguments(options.site, send, take))
    words = [[word for words in each for word in words] for each in (options.serve, options.call, options.params)]
    config = replace(config, rules=add_service_words(config.rules, *words))
    access = add_names(config.rules.access, [site for sites in options.sites for site in sites])
    loss = config.rules.loss_delay if options.loss is None else check_loss(options.loss)
    return replace(
        config,
        rules=replace(config.rules, sites=named_sites(access), access=access, loss_delay=loss),
        connect=(*config.connect, *options.connect),
        listen=(*config.listen, *options.listen),
        keys=options.keys or config.keys,
    )


def _read_keys(config: SiteConfig) -> Mapping[str, str]:
    """Return zenoh's settings for the site's keys; empty if the site has no keys.

    Raises:
        KeysError: the keys cannot be used, or belong to another site.
    """
    if not config.keys:
        return {}
    from pyros1.bridge.transport.certificates import KeysError  # noqa: PLC0415

    rules, keys = config.rules, read_keys(config.keys)
    if keys.site != rules.site:
        raise KeysError(f"{one_line(config.keys)} has the keys of site {keys.site}, not of {rules.site}")
    return make_security(keys, config.connect, config.listen, rules.access, rules.site)


def _run_bridge(invocation: Invocation, config: SiteConfig, security: Mapping[str, str]) -> int:
    from pyros1.bridge.conversions import converters  # noqa: PLC0415
    from pyros1.bridge.transport.zenoh_link import ZenohLink, check_installed  # noqa: PLC0415

    check_installed()
    rules = config.rules
    for rule in rules.send:
        if rule.convert is not None:
            converters.check_installed(rule.convert)
    invocation.master.ping()  # fail before slow imports if no master is running
    from pyros1.bridge.runner import Bridge  # noqa: PLC0415
    from pyros1.node import Node  # noqa: PLC0415

    name = f"bridge_{rules.site}"
    with Node(
        name, argv=invocation.remapping_args, environ=invocation.environ, wait_for_master=0.0, wall_time=True
    ) as node:
        bridge = Bridge(
            node,
            rules,
            lambda receive: ZenohLink(rules.site, receive, config.connect, config.listen, security),
            [each.keys for each in rules.access] if config.keys and config.listen else (),
        )
        try:
            where = " and ".join(
                [*(f"to {each}" for each in config.connect), *(f"on {each}" for each in config.listen)]
            )
            print(f"site {rules.site} {where}; for topics and rates: pyros1 bridge status", file=sys.stderr, flush=True)
            node.spin()
        finally:
            bridge.close()
    return 0


def _parse(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    from pyros1.cli.shared.argparsing import add_options_and_arguments, make_parser  # noqa: PLC0415

    parser = make_parser(invocation, verb)
    add_options_and_arguments(parser, invocation, *verb.options)
    return parser.parse_args(invocation.args), []


VERB = Verb(
    "run",
    "run the bridge of a site (run may be left out)",
    Option("--site", metavar="NAME", help="name of this site, as a namespace: letters, digits, underscores"),
    CONNECT_OPTION,
    LISTEN_OPTION,
    Option(
        "--send",
        nargs="+",
        action="append",
        default=[],
        metavar="TOPIC",
        help="topics to send: /odom, /scan@5 (at most 5 per second), /camera/** (all below), red:/cmd_vel (to site "
        "red, as its /cmd_vel), !/secret (not this one)",
    ),
    Option(
        "--take",
        nargs="+",
        action="append",
        default=[],
        metavar="TOPIC",
        help="topics to take: red:/odom, red:** (all of site red, below /red), *:/odom (of each site), /cmd_vel (what "
        "others send for this site's /cmd_vel)",
    ),
    Option(
        "--serve",
        nargs="+",
        action="append",
        default=[],
        metavar="SERVICE",
        help="services of this site that others may call: /set_map, /camera/**, !/secret",
    ),
    Option(
        "--call",
        nargs="+",
        action="append",
        default=[],
        metavar="SERVICE",
        help="services of other sites to provide here: red:/set_map (as /red/set_map), red:**, *:/spawn",
    ),
    Option(
        "--params",
        nargs="+",
        action="append",
        default=[],
        metavar="NAME",
        help="parameters that others may read: /robot_description, /camera/** (with `pyros1 bridge param` there)",
    ),
    *OPTIONS,
    Option("--config", metavar="FILE", help="YAML file with these settings and more"),
    Option("--keys", metavar="FOLDER", help="this site's keys, made by `pyros1 bridge keys`, for tls/ and quic/"),
    SITES_OPTION,
    Option(
        "--loss",
        type=float,
        metavar="SECONDS",
        help="seconds without a response after which another site, or a node that it listens to, is lost (default: 5)",
    ),
    Flag("--check", help="explain what would be sent and received, and exit"),
    INSECURE_FLAG,
    description="Exchange topics with the masters of other sites. What site red sends appears below /red on the other "
    "masters; nothing is sent or received unless it is named.",
    examples=[
        (
            "pyros1 bridge --site base --listen tls/0.0.0.0:7447 --keys base --sites red --take 'red:**'",
            "at the base",
        ),
        (
            "pyros1 bridge --site red --to tls/base.example:7447 --keys red --send /odom /scan@5 --take /cmd_vel",
            "at the robot",
        ),
        ("--config red.yaml --check", "explain the rules in a file"),
    ],
    stock="",
    parse=_parse,
    run=run,
)
