"""``bridge ros2``: exchanges topics, services and actions with ROS 2, with or without an installation of it."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any

from pyros1.cli.commands.bridge._ros2_via import (
    WAYS,
    Way,
    check_way,
    choose_way,
    describe_way,
    make_side,
    packages_line,
)
from pyros1.cli.commands.bridge._settings import INSECURE_FLAG, check_connections, read_keys
from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Flag, Option, Verb
from pyros1.ground.suggest import did_you_mean
from pyros1.ground.terminal_text import one_line

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from pyros1.ros2.bridge.rules import Ros2Rules
    from pyros1.ros2.pairs.lookup_cache import TimeBudget
    from pyros1.ros2.pairs.type_pairs import TypePairs
    from pyros1.ros2_types.mapping import TypeMapping

_ROUTER = "tcp/localhost:7447"
"""The default endpoint of rmw_zenoh's router."""
_MAX_DOMAIN = 232


def run(invocation: Invocation, options: Any, args: list[str]) -> int | None:
    """Run the bridge until its node shuts down, or explain what it would do."""
    from pyros1.bridge.transport.access_control import security_settings  # noqa: PLC0415
    from pyros1.bridge.transport.certificates import KeysError  # noqa: PLC0415
    from pyros1.bridge.transport.endpoints import EndpointError  # noqa: PLC0415
    from pyros1.ros2.bridge.rules import Ros2Rules, Ros2RulesError  # noqa: PLC0415
    from pyros1.ros2.pairs.mapping_check import check_mapping  # noqa: PLC0415

    if options.pairs is not None:
        return _print_pairs(invocation, options)
    send, take = ([word for words in given for word in words] for given in (options.send, options.take))
    notes = _add_parameters(options.parameters, send, take)
    way = choose_way(options)
    connect = options.connect or ([] if options.listen or way.name == "rclpy" else [_ROUTER])
    try:
        domain = _domain(options.domain, invocation.environ)
        rules = Ros2Rules(send, take, [word for words in options.reconfigure for word in words])
        check_connections(connect, options.listen, options.keys or "", (), options.insecure, {})
        settings: Mapping[str, str] = {}
        if options.keys and not options.check:
            settings = security_settings(read_keys(options.keys), ())
    except (Ros2RulesError, EndpointError, KeysError) as error:
        raise CommandError(str(error), 2) from None
    mapping = _read_mappings(options.mapping)
    if way.name == "rclpy" and options.ros2_packages:
        notes.append("--ros2-packages is not used: through rclpy, types come from its ROS 2 installation")
    if options.check:
        types = _make_types(options, mapping, invocation.environ, way)
        print(f"ROS 2: domain {domain}, through {describe_way(way, connect, options.listen)}")
        print(*map(one_line, rules.explain()), sep="\n")
        if way.name == "rclpy":
            print(one_line(packages_line(), 4000))
        for line in (*notes, *(line for line, _ in check_mapping(mapping, types))):
            print(one_line(line, 1000))
        return None
    return _run(invocation, options, rules, domain, mapping, notes, way, connect, settings)


def _add_parameters(paths: list[str], send: list[str], take: list[str]) -> list[str]:
    """Add the names in parameter_bridge files; return notes on settings that have no effect."""
    from pyros1.ros2.bridge.parameter_file import read_parameters  # noqa: PLC0415

    notes = []
    for path in paths:
        with _reading():
            parameters = read_parameters(path)
        send += parameters.names
        take += parameters.names
        notes += parameters.notes
    return notes


@contextmanager
def _reading() -> Iterator[None]:
    """Turn errors about a file into command errors."""
    from pyros1.bridge.rules.file_reader import RulesError  # noqa: PLC0415
    from pyros1.values.reading import YamlError  # noqa: PLC0415

    try:
        yield
    except OSError as error:
        raise CommandError(f"cannot read {error.filename}: {error.strerror}", 2) from None
    except (RulesError, YamlError) as error:
        raise CommandError(str(error), 2) from None


def _read_mappings(paths: list[str]) -> TypeMapping:
    """Return the rules of mapping files."""
    from pyros1.ros2.pairs.mapping_file import read_mappings  # noqa: PLC0415

    with _reading():
        return read_mappings(paths)


def _make_types(
    options: Any, mapping: TypeMapping, environ: Mapping[str, str], way: Way, budget: TimeBudget | None = None
) -> TypePairs:
    """Return the type pairs of both sides."""
    from pyros1.ros2.pairs.type_pairs import TypePairs  # noqa: PLC0415
    from pyros1.ros2_types.installed import InstalledTypes, PackagesError, environment_folders  # noqa: PLC0415
    from pyros1.ros2_types.rclpy_packages import RclpyPackages  # noqa: PLC0415

    if way.name == "rclpy":
        return TypePairs(options.distribution, mapping, budget=budget, beside_rclpy=RclpyPackages())
    try:
        installed = InstalledTypes([*options.ros2_packages, *environment_folders(environ)])
    except PackagesError as error:
        raise CommandError(str(error), 2) from None
    return TypePairs(options.distribution, mapping, installed, budget)


def _print_pairs(invocation: Invocation, options: Any) -> int:
    """Print the type pairs with these names, or all; return 1 if one of the names is unknown or has no counterpart."""
    from math import inf  # noqa: PLC0415

    from pyros1.cli.shared.definitions import MESSAGE_KIND, SERVICE_KIND, library  # noqa: PLC0415
    from pyros1.ros2.pairs.lookup_cache import TimeBudget  # noqa: PLC0415
    from pyros1.ros2.pairs.pair_list import list_messages, list_services  # noqa: PLC0415
    from pyros1.ros2_types.rclpy_packages import RclpyPackages  # noqa: PLC0415

    wanted = options.pairs
    way = choose_way(options)
    types = _make_types(options, _read_mappings(options.mapping), invocation.environ, way, TimeBudget(inf))
    where = options.distribution
    if way.name == "rclpy":
        where = "beside rclpy"
        for name in wanted or RclpyPackages().messages():
            types.known.get(name)  # reads its definition, since only types that have been read are listed
    messages, services = (
        [name for package in library().packages() for name in kind.type_names(library(), package)]
        for kind in (MESSAGE_KIND, SERVICE_KIND)
    )
    is_missing, unknown = False, {*wanted}
    for title, pairs in (
        ("messages", list_messages(types, messages, types.known, wanted)),
        ("services", list_services(types, services, wanted)),
    ):
        for number, pair in enumerate(pairs):
            if not number:
                print(f"{title}, ROS 1 <-> ROS 2 {where}:")
            print(f"  {pair}", flush=True)
            is_missing = is_missing or not (pair.ros1 and pair.ros2)
            unknown -= {pair.ros1, pair.ros2, pair.ros1.replace("/", "/srv/")}
    for name in sorted(unknown):
        hint = did_you_mean(name, [*messages, *services, *types.known])
        print(f"{one_line(name)}: neither ROS 1 nor ROS 2 has such a type here{hint}", file=sys.stderr)
    return 1 if wanted and (is_missing or unknown) else 0


def _domain(given: int | None, environ: Mapping[str, str]) -> int:
    """Return the ROS domain: from the command line, from ROS_DOMAIN_ID, or 0."""
    text = str(given) if given is not None else environ.get("ROS_DOMAIN_ID") or "0"
    if not text.isascii() or not text.isdigit() or int(text[:9]) > _MAX_DOMAIN:
        what = "ROS_DOMAIN_ID" if given is None else "the domain"
        raise UsageError(f"{what} must be a number from 0 to {_MAX_DOMAIN}, not {text!r:.40}")
    return int(text)


def _run(
    invocation: Invocation,
    options: Any,
    rules: Ros2Rules,
    domain: int,
    mapping: TypeMapping,
    notes: list[str],
    way: Way,
    connect: list[str],
    settings: Mapping[str, str],
) -> int:
    check_way(way, options.listen)
    where = describe_way(way, connect, options.listen)
    invocation.master.ping()  # fail before slow imports if no master is running
    from pyros1.node import Node  # noqa: PLC0415
    from pyros1.ros2.bridge.own_name import own_name  # noqa: PLC0415
    from pyros1.ros2.bridge.runner import Ros2Bridge  # noqa: PLC0415
    from pyros1.ros2.pairs.mapping_check import check_mapping  # noqa: PLC0415

    types = _make_types(options, mapping, invocation.environ, way)
    problems = notes + [line for line, can_be_used in check_mapping(mapping, types) if not can_be_used]
    with Node(
        "bridge_ros2", argv=invocation.remapping_args, environ=invocation.environ, wait_for_master=0.0, wall_time=True
    ) as node:
        name = own_name(node.master)
        bridge = Ros2Bridge(
            node,
            name,
            domain,
            rules,
            types,
            make_side(way, name, domain, connect, options.listen, settings),
            find_name=partial(own_name, node.master),
        )
        try:
            print(
                f"bridge to ROS 2, domain {domain}, through {where}; for topics and rates: pyros1 bridge status",
                file=sys.stderr,
                flush=True,
            )
            for line in problems:
                node.log.warn("%s", one_line(line, 1000))
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
    "ros2",
    "exchange topics, services and actions with ROS 2, with or without an installation of it",
    Option(
        "--via",
        choices=WAYS,
        metavar="WAY",
        help="rclpy: use the ROS 2 installed here, with its middleware; zenoh: needs no ROS 2 here, but its nodes must "
        "use rmw_zenoh; default: zenoh if --to, --listen, --keys or --insecure is given, or rclpy cannot be imported",
    ),
    Option(
        "--to",
        dest="connect",
        action="append",
        default=[],
        metavar="ENDPOINT",
        help=f"where ROS 2's router (rmw_zenohd) listens; default: {_ROUTER}",
    ),
    Option(
        "--listen",
        action="append",
        default=[],
        metavar="ENDPOINT",
        help="be the router, on this endpoint: ROS 2 nodes on this machine look for tcp/localhost:7447",
    ),
    Option("--domain", type=int, metavar="NUMBER", help="the ROS domain; default: ROS_DOMAIN_ID, or 0"),
    Option(
        "--send",
        nargs="+",
        action="append",
        default=[],
        metavar="NAME",
        help="ROS 1 topics, services and actions that ROS 2 may see: /odom, /camera/** (all below), "
        "!/secret (not this one)",
    ),
    Option(
        "--take",
        nargs="+",
        action="append",
        default=[],
        metavar="NAME",
        help="the same for what ROS 1 may see from ROS 2; without --send and --take, everything is exchanged",
    ),
    Option(
        "--reconfigure",
        nargs="+",
        action="append",
        default=[],
        metavar="NODE",
        help="ROS 2 nodes whose parameters tools of dynamic_reconfigure can change: /camera, /arm/** (all below); "
        "default: none",
    ),
    Option(
        "--distribution",
        default="jazzy",
        metavar="NAME",
        help="the ROS 2 distribution whose types are used if no ROS 2 node reports its own: humble, jazzy "
        "(default), ...; with rclpy, the installed types are used",
    ),
    Option(
        "--parameters",
        action="append",
        default=[],
        metavar="FILE",
        help="the topics and services in a YAML file of ros1_bridge's parameter_bridge, besides --send and --take",
    ),
    Option(
        "--mapping",
        action="append",
        default=[],
        metavar="FILE",
        help="which types and fields have other names in ROS 2: a YAML file of rules as for ros1_bridge",
    ),
    Option(
        "--ros2-packages",
        action="append",
        default=[],
        metavar="FOLDER",
        help="ROS 2 packages whose definitions to use, such as a workspace's src or install; besides those of "
        "AMENT_PREFIX_PATH",
    ),
    Option("--keys", metavar="FOLDER", help="keys made by `pyros1 bridge keys`, for tls/ and quic/"),
    Flag("--check", help="explain what would be exchanged, and exit"),
    Option(
        "--pairs",
        nargs="*",
        metavar="TYPE",
        help="print which ROS 1 type is which ROS 2 type, which have no counterpart and why, and exit: all installed "
        "here, or these",
    ),
    INSECURE_FLAG,
    description="Exchange topics, services and actions with ROS 2 nodes: through rclpy, if ROS 2 is installed "
    "here, or else with nodes whose RMW_IMPLEMENTATION is rmw_zenoh_cpp. Each side sees the other's; "
    "messages pass only where somebody subscribes.",
    examples=[
        ("", "through rclpy or, without that, through ROS 2's router (rmw_zenohd) on this machine"),
        ("--listen tcp/localhost:7447", "be that router, if none is running"),
        ("--to tcp/robot:7447 --insecure --send /cmd_vel --take '/scan' '/tf*'", "with a robot; only these topics"),
        ("--pairs sensor_msgs/Imu std_srvs/srv/SetBool", "say what these types are on the other side"),
        ("--reconfigure /camera", "everything, and the parameters of a node for `pyros1 dynparam` and rqt_reconfigure"),
    ],
    stock="",
    parse=_parse,
    run=run,
)
