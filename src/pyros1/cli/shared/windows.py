"""The GUI programs of stock ROS, and their command lines translated for ``pyros1 web``. Pure.

Options that only affect how a window looks or loads have no meaning for a page and are left out. For an option that a
user would miss, one line is printed.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

from pyros1.cli.failures import UsageError

_LAYOUTS = "the page cannot read rqt perspectives; its Layouts button saves and shares layouts"
_NO_EMBEDDING = "a page cannot control another window or be embedded in one; this option has no effect"
_NO_NOTE = ""
"""The note for an option that has no effect on a page."""


class Meaning(NamedTuple):
    """The equivalent of a stock program's option in ``pyros1 web``.

    Attributes:
        word: the option of ``pyros1 web``; empty if it has none.
        value: whether a value follows.
        note: one line for the user, empty for none.
    """

    word: str = ""
    value: bool = False
    note: str = _NO_NOTE


_IGNORED = Meaning()
_IGNORED_VALUE = Meaning(value=True)
_RQT: Mapping[str, Meaning] = {
    "-b": _IGNORED_VALUE, "--qt-binding": _IGNORED_VALUE,
    "--clear-config": _IGNORED, "--force-discover": _IGNORED, "--reload-import": _IGNORED,
    "-f": _IGNORED, "--freeze-layout": _IGNORED,
    "-ht": _IGNORED, "--hide-title": _IGNORED,
    "-l": _IGNORED, "--lock-perspective": _IGNORED,
    "-m": _IGNORED, "--multi-process": _IGNORED,
    "-t": _IGNORED, "--on-top": _IGNORED,
    "-v": _IGNORED, "--verbose": _IGNORED,
    "--perspective": Meaning(value=True, note=_LAYOUTS),
    "--perspective-file": Meaning(value=True, note=_LAYOUTS),
    "--command-pid": Meaning(value=True, note=_NO_EMBEDDING),
    "--command-start-plugin": Meaning(value=True, note=_NO_EMBEDDING),
    "--command-switch-perspective": Meaning(value=True, note=_NO_EMBEDDING),
    "--embed-plugin": Meaning(value=True, note=_NO_EMBEDDING),
    "--embed-plugin-serial": Meaning(value=True, note=_NO_EMBEDDING),
    "--embed-plugin-address": Meaning(value=True, note=_NO_EMBEDDING),
}  # fmt: skip
_PERSPECTIVE: Mapping[str, Meaning] = {"-p": Meaning(value=True, note=_LAYOUTS)}
_RQT_ALONE: Mapping[str, Meaning] = {
    **_RQT, **_PERSPECTIVE,
    "-s": Meaning("--standalone", value=True), "--standalone": Meaning("--standalone", value=True),
    "--args": _IGNORED,
    "--list-perspectives": Meaning(note=_LAYOUTS),
    "--list-plugins": Meaning("--list-plugins"),
}  # fmt: skip
_PLOT: Mapping[str, Meaning] = {
    **_RQT,
    "-P": Meaning("--start-paused"), "--pause": Meaning("--start-paused"), "--start-paused": Meaning("--start-paused"),
    "-e": Meaning("--empty"), "--empty": Meaning("--empty"),
}  # fmt: skip
_RXPLOT_NOTES = {
    ("-b", "--buffer"): "the page keeps at least the period that it shows (-p); its CSV button saves it",
    ("-r", "--refresh"): "the page redraws whenever the browser does; this option has no effect",
    ("-m", "--marker"): "the page draws curves as lines, without markers",
    ("-t", "--title"): "a plot on the page has no title; its Layouts button saves it under a name",
    ("-l", "--legend"): "the page labels curves by their fields",
    ("-M", "--mode"): "the page plots curves over time; --xy plots the second of two against the first",
}
_RXPLOT: Mapping[str, Meaning] = {
    **{name: Meaning(value=True, note=note) for names, note in _RXPLOT_NOTES.items() for name in names},
    "-P": Meaning("--start-paused"),
}
_RVIZ: Mapping[str, Meaning] = {
    "-s": _IGNORED_VALUE, "--splash-screen": _IGNORED_VALUE,
    "--help-file": _IGNORED_VALUE, "--opengl": _IGNORED_VALUE,
    "-l": _IGNORED, "--ogre-log": _IGNORED, "--in-mc-wrapper": _IGNORED,
    "--disable-anti-aliasing": _IGNORED, "--no-stereo": _IGNORED,
    "-v": _IGNORED, "--verbose": _IGNORED, "--log-level-debug": _IGNORED,
    "--fullscreen": _IGNORED,
    "-t": Meaning("--target-frame", value=True), "--target-frame": Meaning("--target-frame", value=True),
}  # fmt: skip


class Program(NamedTuple):
    """A GUI program.

    Attributes:
        words: the words after ``pyros1 web`` that open its panel.
        options: its options that ``pyros1 web`` does not have, or has with another meaning.
    """

    words: tuple[str, ...]
    options: Mapping[str, Meaning] = {}


PROGRAMS: Mapping[str, Program] = {
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
    "rxgraph": Program(("graph",), {"-o": Meaning("--output", value=True)}),
    "rxplot": Program(("plot",), _RXPLOT),
}
"""Stock's GUI programs by name. ``pyros1 setup`` provides all; those in `PACKAGED` are in packages of ours."""

PARTS: Mapping[str, tuple[str, str]] = {"reconfigure": ("params", "reconfigure"), "publisher": ("topics", "publish")}
"""Parts of panels that are plugins in rqt: the panel, and the setting for the name of a node or topic, or ""."""

PACKAGED: Mapping[str, tuple[str, ...]] = {
    **{name: (name,) for name in PROGRAMS if name.startswith("rqt_")},
    "image_view": ("image_view",),
    "rviz": ("rviz",),
}
"""Package -> its programs of `PROGRAMS`."""
DEFAULT_RVIZ_FILE = "~/.rviz/default.rviz"
"""The file that rviz opens if none is named."""
_TRANSPORTS = frozenset({"raw", "compressed"})


class Call(NamedTuple):
    """A call of ``pyros1 web`` in place of a stock program.

    Attributes:
        words: the words after ``pyros1 web``.
        notes: lines for the user.
    """

    words: list[str]
    notes: list[str]


def call_of(program: str, words: Sequence[str]) -> Call:
    """Return the call of ``pyros1 web`` for a stock program's command line.

    Args:
        program: one of `PROGRAMS`.
        words: the words after its name, without remappings.

    Raises:
        UsageError: an option lacks a value, or has one but accepts none.
    """
    known = PROGRAMS[program]
    result = [*known.words]
    notes: list[str] = []
    remaining = [*words]
    while remaining:
        word = remaining.pop(0)
        option, equals, value = word.partition("=") if word.startswith("--") else (word, "", "")
        meaning = known.options.get(option)
        if meaning is None:
            result.append(word)
            continue
        if meaning.value and not equals:
            if not remaining:
                raise UsageError(f"{option} needs a value")
            value = remaining.pop(0)
        elif equals and not meaning.value:
            raise UsageError(f"{option} takes no value")
        if meaning.note and meaning.note not in notes:
            notes.append(meaning.note)
        if meaning.word:
            result += [meaning.word, value] if meaning.value else [meaning.word]
    return Call(result, notes)


def first_argument(words: Sequence[str], valued: Collection[str]) -> int:
    """Return the index of the first word that is no option and no option's value; the number of words if all are.

    Args:
        words: a command line.
        valued: names of the options that take a value.
    """
    index = 0
    while index < len(words) and words[index].startswith("-"):
        index += 2 if words[index] in valued else 1
    return min(index, len(words))


def picture_topic(words: Sequence[str], remapped: str, transport: str) -> list[str]:
    """Return the topic that image_view displays, as a list: empty if nothing names it.

    Args:
        words: its words without options: the transport, or a topic, or both.
        remapped: what its topic ``image`` is remapped to; empty for nothing.
        transport: its private parameter ``image_transport``; empty for none.
    """
    topics = [word for word in words if word not in _TRANSPORTS] or [remapped] * bool(remapped)
    selected_transport = next((word for word in words if word in _TRANSPORTS), transport)
    if selected_transport in ("", "raw"):
        return topics
    return [f"{topic.rstrip('/')}/{selected_transport}" for topic in topics]


def has_display(environ: Mapping[str, str], platform: str) -> bool:
    """Return whether a browser can open a window: without one, Linux would start a browser for terminals.

    Args:
        environ: environment variables.
        platform: ``sys.platform``.
    """
    return platform != "linux" or any(map(environ.get, ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")))
