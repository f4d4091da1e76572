"""``pyros1 web``: displays the running robot in a browser."""

from __future__ import annotations

import contextlib
import os
import socket
import sys
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from pyros1.cli.failures import CommandError, UsageError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import parse_arg_list
from pyros1.cli.records import Argument, Command, Flag, Option, Verb
from pyros1.cli.shared.gui_programs import (
    DEFAULT_RVIZ_FILE,
    GUI_PROGRAMS,
    PANEL_PARTS,
    first_argument_index,
    has_display,
    select_image_topic,
    translate_call,
)
from pyros1.cli.shared.listen_options import ALLOW_OPTION, with_listen_options
from pyros1.ground.names import parse_arguments
from pyros1.ground.terminal_text import one_line

if TYPE_CHECKING:
    from pyros1.node import Node
    from pyros1.web.bags.granted_files import GrantedFiles

WEB_PORT = 9090
_MAX_PAGES_LIMIT = 10_000
_ALL_INTERFACES = ("0.0.0.0", "::", "")
_SINGLE_NAME_PANELS = {
    "image": ("topic", "topic"),
    "topics": ("selected", "topic"),
    "services": ("selected", "service"),
    "nodes": ("selected", "node"),
    "launches": ("node", "node"),
    "turtles": ("node", "node"),
}
"""For each panel that accepts one name: the panel's setting for the name, and what the name refers to."""
_IMAGE_TOPIC = "image"
"""The topic that image_view displays unless it is remapped."""


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Serve the page until a signal arrives, or open a panel in a server that is running. Return the exit code."""
    if options.port is not None and not 0 <= options.port <= 65535:
        raise UsageError(f"the port must be from 0 to 65535, not {options.port}")
    if options.max_pages is not None and not 1 <= options.max_pages <= _MAX_PAGES_LIMIT:
        raise UsageError(f"--max-pages must be from 1 to {_MAX_PAGES_LIMIT}, not {options.max_pages}")
    if options.list_plugins:
        print("\n".join(name for name in GUI_PROGRAMS if name.startswith("rqt_") and name != "rqt_gui"))
        return 0
    if options.output:
        return _save_graph(invocation, options.output)
    options.files = []
    if options.standalone:
        args = [*_plugin_args(options.standalone), *args]
    panel, settings = _panel_and_settings(invocation, options, args)
    from pyros1.launch.running.logs import ros_home  # noqa: PLC0415 - not needed for help
    from pyros1.net.connectivity import is_loopback  # noqa: PLC0415
    from pyros1.net.hosts import master_uri  # noqa: PLC0415
    from pyros1.web.bags.granted_files import GrantedFiles  # noqa: PLC0415
    from pyros1.web.links import link_file, link_published, panel_link, running_link, startup_lock  # noqa: PLC0415

    uri = master_uri(os.environ, invocation.special)
    link_path = link_file(ros_home(os.environ), uri)
    granted = GrantedFiles(link_path.with_suffix(".bags"))
    opens_panel = bool(panel or options.program)
    with contextlib.ExitStack() as stack:
        release_lock = stack.enter_context(startup_lock(link_path))
        existing_link = running_link(link_path)
        if opens_panel and existing_link:
            if options.files:
                try:
                    granted.add(options.files)  # under the lock, since other processes may add files as well
                except OSError as error:
                    raise CommandError(
                        f"cannot let the server open the bag: {error.filename}: {error.strerror}"
                    ) from None
            release_lock()
            return _open_in_running_server(invocation, panel_link(existing_link, panel, settings), uri)
        if not existing_link:
            granted.clear()

        def on_started(link: str) -> None:
            stack.enter_context(link_published(link_path, link))
            release_lock()
            url = panel_link(link, panel, settings)
            print(f"view the robot at {uri} in a browser: {url}", flush=True)
            if not is_loopback(options.host):
                warning = "other machines can reach this page; anyone with the link can do everything that it allows"
                print(warning, file=sys.stderr)
            if options.open or opens_panel:
                _open_link(url)

        try:
            _serve(invocation, options, uri, granted, on_started, WEB_PORT if options.port is None else options.port)
        except _CannotListenError:  # for example, a page for another master uses the port
            if options.port is not None or not opens_panel:
                raise
            _serve(invocation, options, uri, granted, on_started, 0)
    return 0


class _CannotListenError(CommandError):
    """The server cannot listen on its port."""


def _save_graph(invocation: Invocation, file: str) -> int:
    """Write the graph to a file, like ``rxgraph -o FILE``. The file's extension determines its format."""
    from pyros1.cli.running import run_command  # noqa: PLC0415

    return run_command("graph", ["--svg" if file.endswith(".svg") else "--dot", file, *invocation.remapping_args])


def _open_in_running_server(invocation: Invocation, link: str, uri: str) -> int:
    """Open a panel of a running server. If a launch started this process, keep running: it may be a required node."""
    print(f"view the robot at {uri} in a browser: {link}", flush=True)
    _open_link(link)
    if "__name" in invocation.special:
        from pyros1.node import Node  # noqa: PLC0415

        with Node("pyros1_web", argv=_node_args(invocation), master_uri=uri, rosout=False) as node:
            node.spin()
    return 0


def _serve(
    invocation: Invocation,
    options: Any,
    uri: str,
    granted: GrantedFiles,
    on_started: Callable[[str], object],
    port: int,
) -> None:
    from pyros1.net.allowlist import make_allowlist  # noqa: PLC0415
    from pyros1.net.hosts import addresses_from_environment  # noqa: PLC0415
    from pyros1.web.robot import Robot  # noqa: PLC0415
    from pyros1.web.run import run_server  # noqa: PLC0415
    from pyros1.web.server.access import Access  # noqa: PLC0415

    environ = with_listen_options(os.environ, options)
    address = addresses_from_environment(environ, invocation.special)
    optional_settings = {"token": options.token, "max_pages": options.max_pages}
    access = Access(
        names=_host_names(options.host, options.names),
        any_address=options.host in _ALL_INTERFACES,
        read_only=options.read_only,
        topics=tuple(options.topics),
        allowlist=make_allowlist(address.allowed),
        origins=frozenset(origin.lower().rstrip("/") for origin in options.origins),
        bags=(*(options.bags or [os.getcwd()]), *options.files),
        granted=granted,
        **{name: value for name, value in optional_settings.items() if value is not None},
    )
    robot = Robot(uri, access, _make_node_factory(invocation, uri, environ))
    try:
        was_killed = run_server(
            robot,
            access,
            options.host,
            port,
            lambda bound_port: on_started(_make_link(options.host, bound_port, access.token)),
        )
        if was_killed:
            print("the node of this server was asked to shut down, so the server shuts down", file=sys.stderr)
    except OSError as error:
        reason = error.strerror or str(error)
        raise _CannotListenError(
            f"cannot listen on {options.host or '*'}:{port}: {reason}. --port 0 selects a free port"
        ) from None


def _parse(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Parse options and arguments. The first argument can be a stock program, followed by its own options."""
    args = invocation.args
    index = first_argument_index(args, [name for option in verb.options if option.takes_value for name in option.names])
    program = args[index] if index < len(args) else ""
    if program not in GUI_PROGRAMS:
        options, panel_args = parse_arg_list(invocation, verb, args)
        options.program = ""
        return options, panel_args
    translated_call = translate_call(program, args[index + 1 :])
    for note in translated_call.notes:
        print(f"{program}: {note}", file=sys.stderr)
    options, panel_args = parse_arg_list(invocation, verb, [*args[:index], *translated_call.args])
    options.program = program
    if panel_args[:1] == ["image"]:
        arguments = parse_arguments(invocation.argv)
        topic = next((new for name, new in arguments.remappings.items() if _is_image_topic(invocation, name)), "")
        panel_args[1:] = select_image_topic(panel_args[1:], topic, arguments.parameters.get("image_transport", ""))
    return options, panel_args


def _plugin_args(plugin: str) -> tuple[str, ...]:
    """Return the arguments for an rqt plugin: ``rqt_plot`` or, with its full name, ``rqt_plot/Plot``."""
    name = plugin.partition("/")[0].partition(".")[0]
    if name not in GUI_PROGRAMS or name == "rqt_gui":
        plugins = ", ".join(name for name in GUI_PROGRAMS if name.startswith("rqt_") and name != "rqt_gui")
        raise UsageError(f"there is no plugin {plugin!r}; the plugins are {plugins}")
    return GUI_PROGRAMS[name].args


def _panel_and_settings(invocation: Invocation, options: Any, args: list[str]) -> tuple[str, dict[str, Any]]:
    """Return the name of the requested panel or layout, which may be empty, and the settings to open it with."""
    if options.layout:
        if args:
            raise UsageError("--layout opens a whole layout: do not name a panel as well")
        return quote(options.layout, safe=""), {}
    if not args:
        return "", {}
    from pyros1.web.server.assets import Assets  # noqa: PLC0415

    panel, *panel_args = args
    panels = Assets().panels
    if panel in PANEL_PARTS and len(panel_args) < 2:
        name, setting = PANEL_PARTS[panel]
        return name, {setting: invocation.resolve(panel_args[0]) if panel_args else ""}
    if panel not in panels:
        hint = did_you_mean(panel, [*panels, *GUI_PROGRAMS, *PANEL_PARTS])
        raise UsageError(f"there is no panel {panel!r}{hint}; the panels are {', '.join(panels)}")
    if panel in _SETTINGS_FUNCTIONS:
        return panel, _SETTINGS_FUNCTIONS[panel](invocation, options, panel_args)
    if panel in _SINGLE_NAME_PANELS and len(panel_args) == 1:
        return panel, {_SINGLE_NAME_PANELS[panel][0]: invocation.resolve(panel_args[0])}
    if panel_args:
        expected_arguments = f"one {_SINGLE_NAME_PANELS[panel][1]}" if panel in _SINGLE_NAME_PANELS else "no arguments"
        raise UsageError(f"the panel {panel} takes {expected_arguments}")
    return panel, {}


def _bag_settings(invocation: Invocation, options: Any, files: list[str]) -> dict[str, Any]:
    from pyros1.cli.shared.bag_files import check_bag  # noqa: PLC0415 - only needed for this panel

    for file in files:
        check_bag(file)
    options.files = [os.path.abspath(file) for file in files]
    clock_settings = {"clock": True} if options.clock else {}
    return {"files": options.files, **clock_settings} if files else clock_settings


def _plot_settings(invocation: Invocation, options: Any, args: list[str]) -> dict[str, Any]:
    from pyros1.cli.shared.curves import expand_messages, parse_curves  # noqa: PLC0415

    curves = expand_messages(invocation, [curve for arg in args for curve in parse_curves(invocation, arg)])
    settings: dict[str, Any] = {"curves": curves} if curves or options.empty else {}
    if options.period is not None:
        settings["period"] = options.period
    if options.paused:
        settings["paused"] = True
    if options.xy:
        settings["xy"] = True
    return settings


def _scene_settings(invocation: Invocation, options: Any, args: list[str]) -> dict[str, Any]:
    """Return the settings of the scene from the given rviz file or from rviz's default file."""
    if len(args) > 1 or (args and options.display_config):
        raise UsageError("the panel scene takes a single rviz file")
    given_file = args[0] if args else options.display_config
    default_file = os.path.expanduser(DEFAULT_RVIZ_FILE) if options.program == "rviz" else ""
    settings: dict[str, Any] = {}
    if file := given_file or (default_file if os.path.isfile(default_file) else ""):
        from pyros1.web.scene.rviz.file import MAX_FILE_SIZE, RvizFileError, read_rviz  # noqa: PLC0415

        try:
            with open(file, "rb") as stream:
                text = stream.read(MAX_FILE_SIZE + 1).decode(errors="replace")
            settings, notes = read_rviz(text, invocation.resolve)
            lines = [f"{one_line(file)}: {note}" for note in notes]
        except OSError as error:
            lines = [f"cannot read {one_line(file)}: {error.strerror}"]
        except (RvizFileError, ValueError) as error:
            lines = [f"{one_line(file)} {error}"]
        else:
            given_file = ""
        if given_file:
            raise CommandError(lines[0])
        for line in lines:  # problems with the default file are only reported, and the scene opens without it
            print(line, file=sys.stderr)
    for key, frame in (("fixed", options.fixed_frame), ("target", options.target_frame)):
        if frame:
            settings[key] = frame.lstrip("/")
    return settings


_SETTINGS_FUNCTIONS: Mapping[str, Callable[[Invocation, Any, list[str]], dict[str, Any]]]
_SETTINGS_FUNCTIONS = {"bag": _bag_settings, "plot": _plot_settings, "scene": _scene_settings}
"""For panels with several arguments or their own options: the function that returns the panel's settings."""


COMMAND = Command(
    "web",
    "display the running robot in a browser",
    Verb(
        "",
        "",
        Option("--port", type="int", metavar="PORT", help=f"port of the page ({WEB_PORT}); 0: any free port"),
        Option(
            "--host",
            "--bind",
            default="localhost",
            metavar="ADDRESS",
            help="interface to listen on (localhost); 0.0.0.0: all, so that other machines can see the page",
        ),
        ALLOW_OPTION,
        Option(
            "--name",
            dest="names",
            action="append",
            default=[],
            metavar="NAME",
            help="name of this machine to use in links, for example behind a proxy",
        ),
        Option(
            "--token",
            metavar="TOKEN",
            help="token in the link, empty for none (default: a new one at each start)",
        ),
        Option(
            "--origin",
            dest="origins",
            action="append",
            default=[],
            metavar="ORIGIN",
            help="with --token '', a site whose pages may connect, for example http://localhost:8000, or null for "
            "pages opened from a file. With a token, pages of any site that know the token may connect",
        ),
        Flag(
            "--read-only", dest="read_only", help="pages can only view: they cannot publish, call, set or stop anything"
        ),
        Option(
            "--topics",
            action="append",
            default=[],
            metavar="PATTERN",
            help="show only topics (also in bags), services, actions and parameters whose names match, for example "
            "'/camera/*'. Names of nodes and definitions of types stay visible. May be repeated",
        ),
        Option(
            "--bags",
            action="append",
            default=[],
            metavar="FOLDER",
            help="folder in which pages may open and record bags (default: the current folder); may be repeated",
        ),
        Option(
            "--max-pages",
            type="int",
            metavar="COUNT",
            help="maximum number of connected pages, rosbridge clients and viewers (default: 64)",
        ),
        Flag("--open", dest="open", help="open the page in this machine's browser; implied if a panel is given"),
        Option("--layout", metavar="NAME", help="open this layout: Tutorial, 'Mobile robot', Arm, Bag, or your own"),
        Option("-p", "--period", type="float", metavar="SECONDS", help="plot: seconds to show"),
        Flag("-P", "--start-paused", dest="paused", help="plot: start paused"),
        Flag("-e", "--empty", help="plot: start without the previous curves"),
        Flag("--xy", help="plot: draw the second of two curves against the first"),
        Flag("--clock", help="bag: publish the clock while playing"),
        Option("-s", "--standalone", metavar="PLUGIN", help="as in rqt: open the panel for this rqt plugin"),
        Option("-f", "--fixed-frame", metavar="FRAME", help="scene: the fixed frame"),
        Option("--target-frame", metavar="FRAME", help="scene: the frame that the view follows"),
        Option("-d", "--display-config", metavar="FILE", help="scene: a configuration file of rviz"),
        # options of rqt and its plugins; --clear-config and --force-discover have no effect
        Flag("--clear-config", dest="clear_config", hidden=True),
        Flag("--force-discover", dest="force_discover", hidden=True),
        Option("--output", hidden=True),  # rxgraph's
        Flag("--list-plugins", dest="list_plugins", hidden=True),
        Argument("panel", "panel", optional=True, help="the panel to open: graph, console, plot ..."),
        Argument(
            "argument",
            "panel_argument",
            optional=True,
            repeatable=True,
            help="what the panel shows: curves, an image topic, a node, bags",
        ),
        usage="[options] [PANEL [ARGUMENT ...]]",
        description="Display the graph, log, plots, messages, parameters and services in a browser, updated live.",
        examples=[
            ("--open", "open the page in this machine's browser"),
            ("plot /velocity/data,/force_cmd/data", "open a plot, from a running server or a new one"),
            ("plot --xy /odom/pose/pose/position/x:y", "plot one field against another"),
            ("scene -d robot.rviz", "open the displays in a configuration file of rviz"),
            ("bag run.bag", "inspect or play a bag"),
            ("--host 0.0.0.0 --read-only", "let other machines view the page"),
        ],
        parse=_parse,
        run=run,
    ),
    group="inspect",
    # image_view and rqt_gui exist only in packages, for `rosrun`.
    other_programs={name: (name,) for name in GUI_PROGRAMS if name not in ("image_view", "rqt_gui")},
)


def _make_node_factory(invocation: Invocation, uri: str, environ: Mapping[str, str]) -> Callable[[], Node]:
    def make_node() -> Node:
        from pyros1.node import Node  # noqa: PLC0415 - imported in the thread that connects to the master

        return Node(
            "pyros1_web",
            anonymous=True,
            argv=_node_args(invocation),
            master_uri=uri,
            environ=environ,
            handle_signals=False,
            rosout=False,
            wait_for_master=0.0,
            log_level="error",
        )

    return make_node


def _node_args(invocation: Invocation) -> list[str]:
    return [arg for arg in invocation.remapping_args if not _is_image_topic(invocation, arg.partition(":=")[0])]


def _is_image_topic(invocation: Invocation, name: str) -> bool:
    """Return whether a remapped name is image_view's topic, relative or absolute."""
    return invocation.resolve(name) == invocation.resolve(_IMAGE_TOPIC)


def _host_names(host: str, extra_names: list[str]) -> frozenset[str]:
    host_names = {socket.gethostname()} if host in _ALL_INTERFACES else {host}
    return frozenset(name.lower() for name in {*host_names, *extra_names} if name)


def _make_link(host: str, port: int, token: str) -> str:
    url_host = socket.gethostname() if host in _ALL_INTERFACES else host
    if ":" in url_host:
        url_host = f"[{url_host}]"
    return f"http://{url_host}:{port}/" + (f"?token={quote(token, safe='')}" if token else "")


def _open_link(link: str) -> None:
    if has_display(os.environ, sys.platform):
        import webbrowser  # noqa: PLC0415

        if webbrowser.open(link):
            return
    print(f"no browser could be opened here; open the link yourself: {link}", file=sys.stderr, flush=True)
