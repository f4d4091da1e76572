"""``bridge run --dialect zenoh-plugin-ros1``: a bridge to robots that run zenoh-bridge-ros1."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from pyros1.cli.commands.bridge._settings import beside, check_connections, read_file, read_keys
from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Flag, Option
from pyros1.ground.terminal_text import one_line

if TYPE_CHECKING:
    from pyros1.bridge.plugin_ros1.config import PluginConfig

_NATIVE = ("site", "sites", "params")
OPTIONS = (
    Option(
        "--dialect",
        metavar="NAME",
        help="zenoh-plugin-ros1 to talk to robots that run its zenoh-bridge-ros1, instead of pyros1 bridges",
    ),
    Option(
        "--namespace",
        metavar="NAME",
        help="with --dialect: this bridge's namespace; without one, it talks to bridges of all namespaces",
    ),
    Flag("--old-keys", help="with --dialect: the other bridges are older than March 2025"),
)
"""The options of the dialect."""


def wants_plugin(options: Any) -> bool:
    """Return whether the command line or the file selects the dialect.

    Raises:
        YamlError: the file is not valid YAML.
    """
    if options.dialect is None and options.config:
        from pyros1.bridge.plugin_ros1.config import names_dialect  # noqa: PLC0415

        return names_dialect(read_file(options.config), options.config)
    return options.dialect is not None


def run_plugin(invocation: Invocation, options: Any) -> int | None:
    """Run the bridge until its node shuts down, or explain what it would do."""
    from pyros1.bridge.rules.file_reader import RulesError  # noqa: PLC0415
    from pyros1.bridge.transport.access_control import security_settings  # noqa: PLC0415
    from pyros1.bridge.transport.certificates import KeysError  # noqa: PLC0415
    from pyros1.bridge.transport.endpoints import EndpointError  # noqa: PLC0415
    from pyros1.values.reading import YamlError  # noqa: PLC0415

    for name in _NATIVE:
        if getattr(options, name):
            instead = "; with --dialect, use --namespace" if name == "site" else " alone"
            raise UsageError(f"--{name} is for pyros1 bridges{instead}")
    try:
        config = _read_config(options)
        check_connections(config.connect, config.listen, config.keys, (), options.insecure, config.places)
        settings: Mapping[str, str] = {}
        if config.keys and not options.check:
            settings = security_settings(read_keys(config.keys), ())
    except (RulesError, EndpointError, KeysError, YamlError) as error:
        raise CommandError(str(error), 2) from None
    if options.check:
        from pyros1.bridge.plugin_ros1.explanation import explain  # noqa: PLC0415

        print(*map(one_line, explain(config)), sep="\n")
        return None
    if not config.connect and not config.listen:
        raise UsageError("give the endpoint of another bridge with --to, or one to listen on with --listen")
    return _run(invocation, config, settings)


def _read_config(options: Any) -> PluginConfig:
    """Return the configuration from command line and file.

    Raises:
        RulesError: the command line or the file is not valid.
    """
    from pyros1.bridge.plugin_ros1.config import check_dialect, make_config, parse_plugin_config  # noqa: PLC0415

    if options.dialect is not None:
        check_dialect(options.dialect)
    file = None
    if options.config:
        file = parse_plugin_config(read_file(options.config), options.config)
        if file.keys:  # a path in a file is relative to the file
            file = replace(file, keys=beside(file.keys, options.config))
    send, take, serve, call = (
        [word for words in getattr(options, name) for word in words] for name in ("send", "take", "serve", "call")
    )
    config = make_config(options.namespace or "", send, take, serve, call, options.old_keys, file)
    return replace(
        config,
        connect=(*config.connect, *options.connect),
        listen=(*config.listen, *options.listen),
        keys=options.keys or config.keys,
    )


def _run(invocation: Invocation, config: PluginConfig, settings: Mapping[str, str]) -> int:
    from pyros1.bridge.transport.zenoh_link import check_installed  # noqa: PLC0415

    check_installed()
    invocation.master.ping()  # fail before slow imports if no master is running
    from pyros1.bridge.plugin_ros1.keys import ANY, beacon_patterns  # noqa: PLC0415
    from pyros1.bridge.plugin_ros1.runner import PluginBridge  # noqa: PLC0415
    from pyros1.bridge.plugin_ros1.session import PluginSession  # noqa: PLC0415
    from pyros1.node import Node  # noqa: PLC0415

    rules = config.rules
    beacons = beacon_patterns(rules.namespaces())
    name = "bridge_plugin_ros1" if rules.namespace == ANY else f"bridge_{rules.namespace}"
    with Node(
        name, argv=invocation.remapping_args, environ=invocation.environ, wait_for_master=0.0, wall_time=True
    ) as node:
        bridge = PluginBridge(
            node,
            rules,
            lambda on_beacon, on_message, on_call: PluginSession(
                on_beacon, on_message, on_call, beacons, config.connect, config.listen, settings
            ),
        )
        try:
            where = " and ".join(
                [*(f"to {each}" for each in config.connect), *(f"on {each}" for each in config.listen)]
            )
            print(
                f"bridge of zenoh-plugin-ros1 {where}; for topics and rates: pyros1 bridge status",
                file=sys.stderr,
                flush=True,
            )
            node.spin()
        finally:
            bridge.close()
    return 0
