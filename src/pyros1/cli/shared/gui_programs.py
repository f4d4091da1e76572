"""Translates the command lines of the GUI programs of stock ROS to ``pyros1 web``. This module has no side effects.

Options that only affect how a window looks or loads have no meaning for a page and are ignored. For other options
without an equivalent, a note is printed.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

from pyros1.cli.failures import UsageError

_LAYOUTS_NOTE = "the page cannot read rqt perspectives; its Layouts button saves and shares layouts"
_NO_EMBEDDING_NOTE = "a page cannot control another window or be embedded in one; this option has no effect"
_NO_NOTE = ""
"""The empty note: the option is ignored without a message."""


class OptionMapping(NamedTuple):
    """The equivalent of a stock program's option in ``pyros1 web``.

    Attributes:
        equivalent: the equivalent option of ``pyros1 web``; empty if there is none.
        takes_value: whether the option is followed by a value.
        note: a note to print for the user; empty to print none.
    """

    equivalent: str = ""
    takes_value: bool = False
    note: str = _NO_NOTE


_IGNORED_FLAG = OptionMapping()
_IGNORED_WITH_VALUE = OptionMapping(takes_value=True)
_RQT_OPTIONS: Mapping[str, OptionMapping] = {
    "-b": _IGNORED_WITH_VALUE, "--qt-binding": _IGNORED_WITH_VALUE,
    "--clear-config": _IGNORED_FLAG, "--force-discover": _IGNORED_FLAG, "--reload-import": _IGNORED_FLAG,
    "-f": _IGNORED_FLAG, "--freeze-layout": _IGNORED_FLAG,
    "-ht": _IGNORED_FLAG, "--hide-title": _IGNORED_FLAG,
    "-l": _IGNORED_FLAG, "--lock-perspective": _IGNORED_FLAG,
    "-m": _IGNORED_FLAG, "--multi-process": _IGNORED_FLAG,
    "-t": _IGNORED_FLAG, "--on-top": _IGNORED_FLAG,
    "-v": _IGNORED_FLAG, "--verbose": _IGNORED_FLAG,
    "--perspective": OptionMapping(takes_value=True, note=_LAYOUTS_NOTE),
    "--perspective-file": OptionMapping(takes_value=True, note=_LAYOUTS_NOTE),
    "--command-pid": OptionMapping(takes_value=True, note=_NO_EMBEDDING_NOTE),
    "--command-start-plugin": OptionMapping(takes_value=True, note=_NO_EMBEDDING_NOTE),
    "--command-switch-perspective": OptionMapping(takes_value=True, note=_NO_EMBEDDING_NOTE),
    "--embed-plugin": OptionMapping(takes_value=True, note=_NO_EMBEDDING_NOTE),
    "--embed-plugin-serial": OptionMapping(takes_value=True, note=_NO_EMBEDDING_NOTE),
    "--embed-plugin-address": OptionMapping(takes_value=True, note=_NO_EMBEDDING_NOTE),
}  # fmt: skip
_PERSPECTIVE_OPTIONS: Mapping[str, OptionMapping] = {"-p": OptionMapping(takes_value=True, note=_LAYOUTS_NOTE)}
_RQT_PROGRAM_OPTIONS: Mapping[str, OptionMapping] = {
    **_RQT_OPTIONS, **_PERSPECTIVE_OPTIONS,
    "-s": OptionMapping("--standalone", takes_value=True),
    "--standalone": OptionMapping("--standalone", takes_value=True),
    "--args": _IGNORED_FLAG,
    "--list-perspectives": OptionMapping(note=_LAYOUTS_NOTE),
    "--list-plugins": OptionMapping("--list-plugins"),
}  # fmt: skip
_PLOT_OPTIONS: Mapping[str, OptionMapping] = {
    **_RQT_OPTIONS,
    "-P": OptionMapping("--start-paused"), "--pause": OptionMapping("--start-paused"),
    "--start-paused": OptionMapping("--start-paused"),
    "-e": OptionMapping("--empty"), "--empty": OptionMapping("--empty"),
}  # fmt: skip
_RXPLOT_NOTES = {
    ("-b", "--buffer"): "the page keeps at least the data that it shows (see -p); its CSV button saves them",
    ("-r", "--refresh"): "the page redraws whenever the browser does; this option has no effect",
    ("-m", "--marker"): "the page draws curves as lines, without markers",
    ("-t", "--title"): "a plot on the page has no title; its Layouts button saves it under a name",
    ("-l", "--legend"): "the page labels curves by their fields",
    ("-M", "--mode"): "the page plots curves over time; --xy plots the second of two against the first",
}
_RXPLOT_OPTIONS: Mapping[str, OptionMapping] = {
    **{name: OptionMapping(takes_value=True, note=note) for names, note in _RXPLOT_NOTES.items() for name in names},
    "-P": OptionMapping("--start-paused"),
}
_RVIZ_OPTIONS: Mapping[str, OptionMapping] = {
    "-s": _IGNORED_WITH_VALUE, "--splash-screen": _IGNORED_WITH_VALUE,
    "--help-file": _IGNORED_WITH_VALUE, "--opengl": _IGNORED_WITH_VALUE,
    "-l": _IGNORED_FLAG, "--ogre-log": _IGNORED_FLAG, "--in-mc-wrapper": _IGNORED_FLAG,
    "--disable-anti-aliasing": _IGNORED_FLAG, "--no-stereo": _IGNORED_FLAG,
    "-v": _IGNORED_FLAG, "--verbose": _IGNORED_FLAG, "--log-level-debug": _IGNORED_FLAG,
    "--fullscreen": _IGNORED_FLAG,
    "-t": OptionMapping("--target-frame", takes_value=True),
    "--target-frame": OptionMapping("--target-frame", takes_value=True),
}  # fmt: skip


class GuiProgram(NamedTuple):
    """A GUI program of stock ROS.

    Attributes:
        args: the arguments that make ``pyros1 web`` open the program's panel.
        options: the program's options that ``pyros1 web`` lacks or interprets differently.
    """

    args: tuple[str, ...]
    options: Mapping[str, OptionMapping] = {}


GUI_PROGRAMS: Mapping[str, GuiProgram] = {
    "image_view": GuiProgram(("image",)),
    "rqt": GuiProgram(("--open",), _RQT_PROGRAM_OPTIONS),
    "rqt_bag": GuiProgram(("bag",), {**_RQT_OPTIONS, **_PERSPECTIVE_OPTIONS}),
    "rqt_console": GuiProgram(("console",), {**_RQT_OPTIONS, **_PERSPECTIVE_OPTIONS}),
    "rqt_graph": GuiProgram(("graph",), {**_RQT_OPTIONS, **_PERSPECTIVE_OPTIONS}),
    "rqt_gui": GuiProgram(("--open",), _RQT_PROGRAM_OPTIONS),
    "rqt_image_view": GuiProgram(("image",), {**_RQT_OPTIONS, **_PERSPECTIVE_OPTIONS}),
    "rqt_launch": GuiProgram(("launches",), {**_RQT_OPTIONS, **_PERSPECTIVE_OPTIONS}),
    "rqt_logger_level": GuiProgram(("nodes",), {**_RQT_OPTIONS, **_PERSPECTIVE_OPTIONS}),
    "rqt_plot": GuiProgram(("plot",), _PLOT_OPTIONS),
    "rqt_publisher": GuiProgram(("publisher",), {**_RQT_OPTIONS, **_PERSPECTIVE_OPTIONS}),
    "rqt_reconfigure": GuiProgram(("reconfigure",), {**_RQT_OPTIONS, **_PERSPECTIVE_OPTIONS}),
    "rqt_service_caller": GuiProgram(("services",), {**_RQT_OPTIONS, **_PERSPECTIVE_OPTIONS}),
    "rqt_tf_tree": GuiProgram(("frames",), {**_RQT_OPTIONS, **_PERSPECTIVE_OPTIONS}),
    "rqt_top": GuiProgram(("launches",), {**_RQT_OPTIONS, **_PERSPECTIVE_OPTIONS}),
    "rqt_topic": GuiProgram(("topics",), {**_RQT_OPTIONS, **_PERSPECTIVE_OPTIONS}),
    "rviz": GuiProgram(("scene",), _RVIZ_OPTIONS),
    "rxbag": GuiProgram(("bag",)),
    "rxconsole": GuiProgram(("console",)),
    "rxgraph": GuiProgram(("graph",), {"-o": OptionMapping("--output", takes_value=True)}),
    "rxplot": GuiProgram(("plot",), _RXPLOT_OPTIONS),
}
"""GUI programs of stock ROS by name. ``pyros1 setup`` provides all; packages provide those in `PROGRAMS_BY_PACKAGE`."""

PANEL_PARTS: Mapping[str, tuple[str, str]] = {
    "reconfigure": ("params", "reconfigure"),
    "publisher": ("topics", "publish"),
}
"""For each rqt plugin that is part of a panel: the panel, and the panel's setting for the name of a node or topic."""

PROGRAMS_BY_PACKAGE: Mapping[str, tuple[str, ...]] = {
    **{name: (name,) for name in GUI_PROGRAMS if name.startswith("rqt_")},
    "image_view": ("image_view",),
    "rviz": ("rviz",),
}
"""The programs of each package, from `GUI_PROGRAMS`."""
DEFAULT_RVIZ_FILE = "~/.rviz/default.rviz"
"""The file that rviz opens by default."""
_IMAGE_TRANSPORTS = frozenset({"raw", "compressed"})


class TranslatedCall(NamedTuple):
    """A call to ``pyros1 web`` that replaces a call to a stock program.

    Attributes:
        args: the arguments of ``pyros1 web``.
        notes: notes to print for the user.
    """

    args: list[str]
    notes: list[str]


def translate_call(program: str, args: Sequence[str]) -> TranslatedCall:
    """Return the call to ``pyros1 web`` that replaces a stock program's command line.

    Args:
        program: the program, one of `GUI_PROGRAMS`.
        args: the program's arguments without remappings.

    Raises:
        UsageError: an option lacks its value, or has one but accepts none.
    """
    stock_program = GUI_PROGRAMS[program]
    new_args = [*stock_program.args]
    notes: list[str] = []
    remaining = [*args]
    while remaining:
        arg = remaining.pop(0)
        option, equals, value = arg.partition("=") if arg.startswith("--") else (arg, "", "")
        mapping = stock_program.options.get(option)
        if mapping is None:
            new_args.append(arg)
            continue
        if mapping.takes_value and not equals:
            if not remaining:
                raise UsageError(f"{option} needs a value")
            value = remaining.pop(0)
        elif equals and not mapping.takes_value:
            raise UsageError(f"{option} takes no value")
        if mapping.note and mapping.note not in notes:
            notes.append(mapping.note)
        if mapping.equivalent:
            new_args += [mapping.equivalent, value] if mapping.takes_value else [mapping.equivalent]
    return TranslatedCall(new_args, notes)


def first_argument_index(args: Sequence[str], options_with_value: Collection[str]) -> int:
    """Return the index of the first positional argument, or the number of arguments if there is none.

    Args:
        args: the arguments.
        options_with_value: the names of the options that take a value.
    """
    index = 0
    while index < len(args) and args[index].startswith("-"):
        index += 2 if args[index] in options_with_value else 1
    return min(index, len(args))


def select_image_topic(args: Sequence[str], remapped_topic: str, transport: str) -> list[str]:
    """Return a list with the topic that image_view displays; an empty list if no topic is given.

    Args:
        args: image_view's positional arguments: the transport, the topic, or both.
        remapped_topic: the topic to which ``image`` is remapped; empty if it is not remapped.
        transport: the value of the private parameter ``image_transport``; empty if it is not set.
    """
    topics = [arg for arg in args if arg not in _IMAGE_TRANSPORTS] or [remapped_topic] * bool(remapped_topic)
    selected_transport = next((arg for arg in args if arg in _IMAGE_TRANSPORTS), transport)
    if selected_transport in ("", "raw"):
        return topics
    return [f"{topic.rstrip('/')}/{selected_transport}" for topic in topics]


def has_display(environ: Mapping[str, str], platform: str) -> bool:
    """Return whether a browser can open a window. Without a display, Linux would start a text browser.

    Args:
        environ: the environment variables.
        platform: ``sys.platform``.
    """
    return platform != "linux" or any(map(environ.get, ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")))
