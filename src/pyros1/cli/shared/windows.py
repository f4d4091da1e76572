"""Translation of the command lines of stock's GUI programs to ``pyros1 web``. This module has no side effects.

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
"""The note for an option that is silently ignored."""


class OptionMapping(NamedTuple):
    """The equivalent of a stock program's option in ``pyros1 web``.

    Attributes:
        equivalent: the option of ``pyros1 web``; empty if it has none.
        takes_value: whether a value follows.
        note: a note to print for the user; empty for none.
    """

    equivalent: str = ""
    takes_value: bool = False
    note: str = _NO_NOTE


_IGNORED = OptionMapping()
_IGNORED_VALUE = OptionMapping(takes_value=True)
_RQT: Mapping[str, OptionMapping] = {
    "-b": _IGNORED_VALUE, "--qt-binding": _IGNORED_VALUE,
    "--clear-config": _IGNORED, "--force-discover": _IGNORED, "--reload-import": _IGNORED,
    "-f": _IGNORED, "--freeze-layout": _IGNORED,
    "-ht": _IGNORED, "--hide-title": _IGNORED,
    "-l": _IGNORED, "--lock-perspective": _IGNORED,
    "-m": _IGNORED, "--multi-process": _IGNORED,
    "-t": _IGNORED, "--on-top": _IGNORED,
    "-v": _IGNORED, "--verbose": _IGNORED,
    "--perspective": OptionMapping(takes_value=True, note=_LAYOUTS_NOTE),
    "--perspective-file": OptionMapping(takes_value=True, note=_LAYOUTS_NOTE),
    "--command-pid": OptionMapping(takes_value=True, note=_NO_EMBEDDING_NOTE),
    "--command-start-plugin": OptionMapping(takes_value=True, note=_NO_EMBEDDING_NOTE),
    "--command-switch-perspective": OptionMapping(takes_value=True, note=_NO_EMBEDDING_NOTE),
    "--embed-plugin": OptionMapping(takes_value=True, note=_NO_EMBEDDING_NOTE),
    "--embed-plugin-serial": OptionMapping(takes_value=True, note=_NO_EMBEDDING_NOTE),
    "--embed-plugin-address": OptionMapping(takes_value=True, note=_NO_EMBEDDING_NOTE),
}  # fmt: skip
_PERSPECTIVE: Mapping[str, OptionMapping] = {"-p": OptionMapping(takes_value=True, note=_LAYOUTS_NOTE)}
_RQT_ALONE: Mapping[str, OptionMapping] = {
    **_RQT, **_PERSPECTIVE,
    "-s": OptionMapping("--standalone", takes_value=True),
    "--standalone": OptionMapping("--standalone", takes_value=True),
    "--args": _IGNORED,
    "--list-perspectives": OptionMapping(note=_LAYOUTS_NOTE),
    "--list-plugins": OptionMapping("--list-plugins"),
}  # fmt: skip
_PLOT: Mapping[str, OptionMapping] = {
    **_RQT,
    "-P": OptionMapping("--start-paused"), "--pause": OptionMapping("--start-paused"),
    "--start-paused": OptionMapping("--start-paused"),
    "-e": OptionMapping("--empty"), "--empty": OptionMapping("--empty"),
}  # fmt: skip
_RXPLOT_NOTES = {
    ("-b", "--buffer"): "the page keeps at least the period that it shows (-p); its CSV button saves it",
    ("-r", "--refresh"): "the page redraws whenever the browser does; this option has no effect",
    ("-m", "--marker"): "the page draws curves as lines, without markers",
    ("-t", "--title"): "a plot on the page has no title; its Layouts button saves it under a name",
    ("-l", "--legend"): "the page labels curves by their fields",
    ("-M", "--mode"): "the page plots curves over time; --xy plots the second of two against the first",
}
_RXPLOT: Mapping[str, OptionMapping] = {
    **{name: OptionMapping(takes_value=True, note=note) for names, note in _RXPLOT_NOTES.items() for name in names},
    "-P": OptionMapping("--start-paused"),
}
_RVIZ: Mapping[str, OptionMapping] = {
    "-s": _IGNORED_VALUE, "--splash-screen": _IGNORED_VALUE,
    "--help-file": _IGNORED_VALUE, "--opengl": _IGNORED_VALUE,
    "-l": _IGNORED, "--ogre-log": _IGNORED, "--in-mc-wrapper": _IGNORED,
    "--disable-anti-aliasing": _IGNORED, "--no-stereo": _IGNORED,
    "-v": _IGNORED, "--verbose": _IGNORED, "--log-level-debug": _IGNORED,
    "--fullscreen": _IGNORED,
    "-t": OptionMapping("--target-frame", takes_value=True),
    "--target-frame": OptionMapping("--target-frame", takes_value=True),
}  # fmt: skip


class Program(NamedTuple):
    """A GUI program of stock ROS.

    Attributes:
        args: the arguments of ``pyros1 web`` that open its panel.
        options: the program's options that ``pyros1 web`` lacks or interprets differently.
    """

    args: tuple[str, ...]
    options: Mapping[str, OptionMapping] = {}


GUI_PROGRAMS: Mapping[str, Program] = {
    "image_view": Program(("image",)),
    "rqt": Program(("--open",), _RQT_ALONE),
    "rqt_bag": Program(("bag",), {**_RQT, **_PERSPECTIVE}),
    "rqt_console": Program(("console",), {**_RQT, **_PERSPECTIVE}),
    "rqt_graph": Program(("graph",), {**_RQT, **_PERSPECTIVE}),
    "rqt_gui": Program(("--open",), _RQT_ALONE),
    "rqt_image_view": Program(("image",), {**_RQT, **_PERSPECTIVE}),
    "rqt_launch": Program(("launches",), {**_RQT, **_PERSPECTIVE}),
    "rqt_logger_level": Program(("nodes",), {**_RQT, **_PERSPECTIVE}),
    "rqt_plot": Program(("plot",), _PLOT),
    "rqt_publisher": Program(("publisher",), {**_RQT, **_PERSPECTIVE}),
    "rqt_reconfigure": Program(("reconfigure",), {**_RQT, **_PERSPECTIVE}),
    "rqt_service_caller": Program(("services",), {**_RQT, **_PERSPECTIVE}),
    "rqt_tf_tree": Program(("frames",), {**_RQT, **_PERSPECTIVE}),
    "rqt_top": Program(("launches",), {**_RQT, **_PERSPECTIVE}),
    "rqt_topic": Program(("topics",), {**_RQT, **_PERSPECTIVE}),
    "rviz": Program(("scene",), _RVIZ),
    "rxbag": Program(("bag",)),
    "rxconsole": Program(("console",)),
    "rxgraph": Program(("graph",), {"-o": OptionMapping("--output", takes_value=True)}),
    "rxplot": Program(("plot",), _RXPLOT),
}
"""Stock's GUI programs by name. ``pyros1 setup`` provides all. Those in `PROGRAMS_BY_PACKAGE` are also in packages."""

PANEL_PARTS: Mapping[str, tuple[str, str]] = {
    "reconfigure": ("params", "reconfigure"),
    "publisher": ("topics", "publish"),
}
"""Parts of panels that are separate plugins in rqt: the panel, and the setting for the name of a node or topic."""

PROGRAMS_BY_PACKAGE: Mapping[str, tuple[str, ...]] = {
    **{name: (name,) for name in GUI_PROGRAMS if name.startswith("rqt_")},
    "image_view": ("image_view",),
    "rviz": ("rviz",),
}
"""The programs of each package, from `GUI_PROGRAMS`."""
DEFAULT_RVIZ_FILE = "~/.rviz/default.rviz"
"""The file that rviz opens by default."""
_TRANSPORTS = frozenset({"raw", "compressed"})


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


def select_image_topic(args: Sequence[str], remapped: str, transport: str) -> list[str]:
    """Return the topic that image_view displays as a list, which is empty if no topic is given.

    Args:
        args: image_view's positional arguments: the transport, the topic, or both.
        remapped: the topic to which ``image`` is remapped; empty if it is not remapped.
        transport: the private parameter ``image_transport``; empty if it is not set.
    """
    topics = [arg for arg in args if arg not in _TRANSPORTS] or [remapped] * bool(remapped)
    selected_transport = next((arg for arg in args if arg in _TRANSPORTS), transport)
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
