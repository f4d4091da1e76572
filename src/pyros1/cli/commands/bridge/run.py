"""``bridge run``: runs the bridge of a site."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Flag, Option, Verb
from pyros1.ground.terminal_text import one_line

if TYPE_CHECKING:
    from pyros1.bridge.rules.parsing import SiteConfig

_MAX_FILE_SIZE = 1 << 20


def run(invocation: Invocation, options: Any, args: list[str]) -> int | None:
    """Run the bridge until its node shuts down, or explain what it would do."""
    from pyros1.bridge.names import SiteNameError  # noqa: PLC0415
    from pyros1.bridge.rules.parsing import RulesError  # noqa: PLC0415
    from pyros1.bridge.transport.certificates import KeysError  # noqa: PLC0415
    from pyros1.bridge.transport.endpoints import EndpointError, check_endpoint, check_security  # noqa: PLC0415
    from pyros1.values.reading import YamlError  # noqa: PLC0415

    try:
        config = _read_config(options)
        for endpoint in (*config.connect, *config.listen):
            check_endpoint(endpoint)
        check_security(config.connect, config.listen, bool(config.keys), options.insecure)
        security = {} if options.check else _read_keys(config)
    except (RulesError, SiteNameError, EndpointError, KeysError, YamlError) as error:
        raise CommandError(str(error), 2) from None
    if options.check:
        from pyros1.bridge.rules.explanation import explain  # noqa: PLC0415

        print(*map(one_line, explain(config)), sep="\n")
        return None
    if not config.connect and not config.listen:
        raise UsageError("give the endpoint of another site with --to, or one to listen on with --listen")
    return _run_bridge(invocation, config, security)


def _read_config(options: Any) -> SiteConfig:
    """Return what the command line and the file say together.

    Raises:
        RulesError, SiteNameError: one of them is not valid.
    """
    from dataclasses import replace  # noqa: PLC0415

    from pyros1.bridge.names import check_site_name  # noqa: PLC0415
    from pyros1.bridge.rules.parsing import SiteConfig, add_words, parse_config, rules_from_words  # noqa: PLC0415

    send = [word for words in options.send for word in words]
    take = [word for words in options.take for word in words]
    if options.config:
        with open(options.config, "rb") as file:
            text = file.read(_MAX_FILE_SIZE + 1)
        if len(text) > _MAX_FILE_SIZE:
            raise CommandError(f"{one_line(options.config)} has more than {_MAX_FILE_SIZE >> 20} MB", 2)
        config = add_words(parse_config(text.decode(), options.config, options.site or ""), send, take)
        if config.keys:  # a path in a file is relative to the file
            folder = Path(options.config).parent / Path(config.keys).expanduser()
            config = replace(config, keys=str(folder))
    elif not options.site:
        raise UsageError("name this site with --site, or give a file with --config")
    else:
        config = SiteConfig(rules_from_words(options.site, send, take))
    sites = tuple(check_site_name(site) for sites in options.sites for site in sites)
    return replace(
        config,
        rules=replace(config.rules, sites=(*config.rules.sites, *sites)),
        connect=(*config.connect, *options.connect),
        listen=(*config.listen, *options.listen),
        keys=options.keys or config.keys,
    )


def _read_keys(config: SiteConfig) -> Mapping[str, str]:
    """Return the settings of zenoh for the site's keys, if it has any.

    Raises:
        KeysError: they cannot be used.
    """
    if not config.keys:
        return {}
    from pyros1.bridge.transport.access_control import security_settings  # noqa: PLC0415
    from pyros1.bridge.transport.certificates import EXPIRY_WARNING_DAYS, KeysError, load_keys  # noqa: PLC0415

    keys = load_keys(Path(config.keys).expanduser())
    if keys.site != config.rules.site:
        raise KeysError(f"{one_line(config.keys)} has the keys of site {keys.site}, not of {config.rules.site}")
    if (days := keys.days_left()) < EXPIRY_WARNING_DAYS:
        print(f"WARNING: the keys in {one_line(config.keys)} expire in {days} days", file=sys.stderr)
    if config.listen and (config.connect or not config.rules.sites):
        reason = "this site also connects to others" if config.rules.sites else "no sites are named with --sites"
        print(f"WARNING: {reason}, so any site with keys can impersonate another one here", file=sys.stderr)
    # Where this site connects to another one, packets of third sites come under that one's certificate.
    return security_settings(keys, config.rules.sites if config.listen and not config.connect else ())


def _run_bridge(invocation: Invocation, config: SiteConfig, security: Mapping[str, str]) -> int:
    from pyros1.bridge.transport.zenoh_link import ZenohLink, check_installed  # noqa: PLC0415

    check_installed()
    rules = config.rules
    invocation.master.ping()  # fail before slow imports if no master is running
    from pyros1.bridge.runner import Bridge  # noqa: PLC0415
    from pyros1.node import Node  # noqa: PLC0415

    name = f"bridge_{rules.site}"
    with Node(
        name, argv=invocation.remapping_args, environ=invocation.environ, wait_for_master=0.0, wall_time=True
    ) as node:
        bridge = Bridge(
            node, rules, lambda receive: ZenohLink(rules.site, receive, config.connect, config.listen, security)
        )
        try:
            where = " and ".join(
                [*(f"to {each}" for each in config.connect), *(f"on {each}" for each in config.listen)]
            )
            print(f"site {rules.site} {where}; to see what flows: pyros1 bridge status", file=sys.stderr, flush=True)
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
    Option(
        "--to",
        dest="connect",
        action="append",
        default=[],
        metavar="ENDPOINT",
        help="where another site listens, for example tls/base.example:7447; may be repeated",
    ),
    Option(
        "--listen",
        action="append",
        default=[],
        metavar="ENDPOINT",
        help="where to listen for other sites, for example tls/0.0.0.0:7447; may be repeated",
    ),
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
    Option("--config", metavar="FILE", help="YAML file with these settings and more"),
    Option("--keys", metavar="FOLDER", help="this site's keys, made by `pyros1 bridge keys`, for tls/ and quic/"),
    Option(
        "--sites",
        nargs="+",
        action="append",
        default=[],
        metavar="NAME",
        help="talk only to these sites; where this site listens with --keys, only they are let in, and none can "
        "impersonate another",
    ),
    Flag("--check", help="explain what would be sent and received, and exit"),
    Flag(
        "--insecure",
        help="use unencrypted endpoints beyond this machine, although anybody who reaches them can read what is sent, "
        "and send",
    ),
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
