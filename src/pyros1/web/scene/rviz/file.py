"""Converts rviz's display configuration files to settings of the 3D panel (`page/panels/scene.js`) (no I/O).

A file's YAML is untrusted: it is read within limits, and anything that is not in the form that rviz writes is treated
as absent.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.values import YamlError, load_yaml
from pyros1.web.scene.rviz.defaults import differs_from_default
from pyros1.web.scene.rviz.topic_displays import TOPIC_DISPLAYS, Options
from pyros1.web.scene.rviz.values import (
    Properties,
    boolean,
    class_of,
    colour,
    drop_none,
    list_or_empty,
    mapped_choice,
    mapping_or_empty,
    number,
    point,
    text,
)
from pyros1.web.scene.rviz.view import FIXED_FRAME_NAME, view_settings

MAX_FILE_SIZE = 2_000_000
"""Maximum size of a file in bytes, and in characters."""
_MAX_DISPLAYS = 200
_MAX_DEPTH = 10
_MAX_NOTES = 40
_WINDOW_HEIGHT = 800.0
"""Height in pixels that rviz's window is assumed to have if the file does not specify it."""
_AXES_LENGTH = 0.2
"""Length in metres of the axes in rviz's TF display, at a marker scale of 1."""
_GRID_COLOUR = "#a0a0a4"
"""rviz's default colour for grids; the page's default depends on its theme (light or dark)."""
_BACKGROUND_COLOUR = "#303030"
"""rviz's default background colour; the page's default depends on its theme."""
_MAX_HIDDEN_PARTS = 200
_FRAMES = "frames"
_GRID = "grid"


class RvizFileError(Error):
    """A file is not an rviz configuration file."""


class RvizFile(NamedTuple):
    """The result of converting an rviz file.

    Attributes:
        settings: the settings of the 3D panel.
        notes: lines for the user about what the panel does not support.
    """

    settings: dict[str, Any]
    notes: list[str]


def read_rviz(content: str, resolve: Callable[[str], str]) -> RvizFile:
    """Convert an rviz file.

    Args:
        content: the file's content: YAML saved by rviz.
        resolve: returns the full name of a topic or parameter.

    Raises:
        RvizFileError: this is not an rviz file. The error message says why, without the file's name.
    """
    if len(content) > MAX_FILE_SIZE:
        raise RvizFileError(f"is not an rviz file: it is longer than {MAX_FILE_SIZE} characters")
    try:
        data = load_yaml(content)
    except YamlError as error:
        raise RvizFileError(f"is not YAML: {one_line(str(error))}") from None
    manager = mapping_or_empty(mapping_or_empty(data).get("Visualization Manager"))
    if not manager:
        raise RvizFileError('has no "Visualization Manager": it was not saved by rviz')
    return _Reader(resolve).read(data, manager)


_PANELS = frozenset({"Displays", "Help", "Selection", "Time", "Tool Properties", "Views"})
_TOOLS = frozenset(
    {"FocusCamera", "Interact", "Measure", "MoveCamera", "PublishPoint", "Select", "SetGoal", "SetInitialPose"}
)
_PUBLISHING_TOOLS = {
    "SetGoal": ("goal", "/move_base_simple/goal"),
    "SetInitialPose": ("estimate", "/initialpose"),
    "PublishPoint": ("point", "/clicked_point"),
}
"""Publishing tool in rviz -> its name in the panel, and its default topic."""


class _Reader:
    """Converts one file."""

    def __init__(self, resolve: Callable[[str], str]) -> None:
        self._resolve = resolve
        self._topics: list[str] = []
        self._robots: list[str] = []
        self._hidden: list[str] = []
        self._options: dict[str, Options] = {}
        self._tools: dict[str, str] = {}
        self._notes: list[str] = []

    def read(self, data: Mapping[Any, Any], manager: Mapping[Any, Any]) -> RvizFile:
        global_options = Properties(mapping_or_empty(manager.get("Global Options")))
        fixed = text(global_options, "Fixed Frame").lstrip("/")
        visible = {_FRAMES: False, _GRID: False}
        for count, (display, enabled) in enumerate(self._displays(manager.get("Displays"))):
            if count == _MAX_DISPLAYS:
                self._note(f"more than {_MAX_DISPLAYS} displays: the others are ignored")
                break
            self._read_display(display, enabled, visible)
        self._hidden += [key for key, is_visible in visible.items() if not is_visible]
        height = number(mapping_or_empty(data.get("Window Geometry")), "Height", 100, 10_000) or _WINDOW_HEIGHT
        current_view = Properties(mapping_or_empty(mapping_or_empty(manager.get("Views")).get("Current")))
        view, note = view_settings(current_view, height)
        self._note(note)
        if not note:
            self._note_unsupported(current_view, f"view {class_of(current_view)}")
        background = colour(global_options, "Background Color")
        self._note_unsupported(global_options, "Global Options")
        settings = {
            "fixed": "" if fixed == FIXED_FRAME_NAME else fixed,
            "topics": self._topics,
            "robots": self._robots,
            "options": {key: options for key, options in self._options.items() if options},
            "hidden": self._hidden,
            **view,
        }
        if background not in (None, _BACKGROUND_COLOUR):
            settings["background"] = background
        self._read_tools_and_panels(data, manager)
        if self._tools:
            settings["tools"] = self._tools
        if len(self._notes) > _MAX_NOTES:
            self._notes[_MAX_NOTES:] = [f"and {len(self._notes) - _MAX_NOTES} more that are not supported"]
        return RvizFile(settings, self._notes)

    def _displays(self, displays: Any, enabled: bool = True, depth: int = 0) -> Iterator[tuple[Properties, bool]]:
        """Yield each display, including those in groups, and whether it is enabled."""
        for values in map(mapping_or_empty, list_or_empty(displays)):
            display = Properties(values)
            is_enabled = enabled and boolean(display, "Enabled") is not False
            if class_of(display) != "Group":
                yield display, is_enabled
            elif depth < _MAX_DEPTH:
                yield from self._displays(display.get("Displays"), is_enabled, depth + 1)

    def _read_display(self, display: Properties, enabled: bool, visible: dict[str, bool]) -> None:
        class_name = class_of(display)
        if class_name == "TF":
            visible[_FRAMES] = visible[_FRAMES] or enabled
            self._read_frames(display)
        elif class_name == "Grid":
            visible[_GRID] = visible[_GRID] or enabled
            self._read_grid(display)
        elif class_name == "Axes":
            if enabled:
                self._note(f"{_display_name(display)}: use the TF display for axes of frames")
        elif class_name == "RobotModel":
            self._read_robot(display, enabled)
        elif class_name in TOPIC_DISPLAYS:
            self._read_topic(display, enabled, class_name)
        else:
            self._note(
                f"{_display_name(display)}: unsupported display {one_line(text(display, 'Class')) or 'without a class'}"
            )

    def _read_topic(self, display: Properties, enabled: bool, class_name: str) -> None:
        options, keys, prefix, shows_images = TOPIC_DISPLAYS[class_name]
        topic = text(display, *keys)
        if not topic:
            self._note(f"{_display_name(display)}: it has no topic")
            return
        name = self._resolve(topic)
        hint = text(display, "Transport Hint")
        if shows_images and hint in ("compressed", "compressedDepth"):
            name = f"{name}/{hint}"
        key = f"{prefix}{name}"
        if key in self._topics:
            self._note(f"{_display_name(display)}: ignored, since another display shows {one_line(name)}")
            return
        self._topics.append(key)
        self._options[key] = options(display)
        if class_name == "DepthCloud" and (colours := text(display, "Color Image Topic")):
            self._options[key]["colour"] = self._resolve(colours)
        if class_name == "Effort" and (description := text(display, "Robot Description")):
            self._options[key]["description"] = self._resolve(description)
        if not enabled:
            self._hidden.append(key)
        self._note_unsupported(display)

    def _note_unsupported(self, values: Properties, name: str = "", ignored: tuple[str, ...] = ()) -> None:
        """Add a note about the properties that were not read, unless they have rviz's default values."""
        class_name = class_of(values)
        missing = [
            f"{key} {value}" if isinstance(value, str) and value else key
            for key, value in values.unread()
            if key.partition("/")[0] not in ignored and differs_from_default(class_name, key, value)
        ]
        if missing:
            self._note(one_line(f"{name or _display_name(values)}: not supported: {', '.join(missing)}"))

    def _read_robot(self, display: Properties, enabled: bool) -> None:
        name = self._resolve(text(display, "Robot Description") or "robot_description")
        key = f"robot:{name}"
        if name in self._robots:
            self._note(f"{_display_name(display)}: ignored, since another display shows the robot in {one_line(name)}")
            return
        self._robots.append(name)
        self._options[key] = drop_none(
            visual=boolean(display, "Visual Enabled"),
            collision=boolean(display, "Collision Enabled"),
            alpha=number(display, "Alpha", 0, 1),
            prefix=text(display, "TF Prefix") or None,
            concealed=_hidden_parts(display.get("Links")),
        )
        if not enabled:
            self._hidden.append(key)
        links = [mapping_or_empty(link) for link in mapping_or_empty(display.get("Links")).values()]
        if any(
            boolean(link, "Show Axes") or boolean(link, "Show Trail") or number(link, "Alpha", 0, 1) not in (None, 1)
            for link in links
        ):
            self._note(f"{_display_name(display)}: axes, trails and the alpha of single links are not supported")
        self._note_unsupported(display, ignored=("Links",))

    def _read_frames(self, display: Properties) -> None:
        scale = number(display, "Marker Scale", 0.05, 300)
        self._options[_FRAMES] = drop_none(
            names=boolean(display, "Show Names"),
            axes=boolean(display, "Show Axes"),
            lines=boolean(display, "Show Arrows"),
            size=None if scale is None else round(_AXES_LENGTH * scale, 3),
            concealed=_hidden_parts(display.get("Frames")),
        )
        self._note_unsupported(display, ignored=("Frames", "Tree"))

    def _read_grid(self, display: Properties) -> None:
        if _GRID in self._options:
            self._note(f"{_display_name(display)}: only one grid is supported")
            return
        tint = colour(display)
        count = number(display, "Plane Cell Count", 1, 200)
        line = mapping_or_empty(display.get("Line Style"))
        offset = display.get("Offset")
        mapped_choice(display, {FIXED_FRAME_NAME: FIXED_FRAME_NAME}, "Reference Frame")
        self._options[_GRID] = drop_none(
            count=None if count is None else int(count),
            cell=number(display, "Cell Size", 0.01, 1000),
            flat=tint not in (None, _GRID_COLOUR) or None,
            tint=tint,
            alpha=number(display, "Alpha", 0, 1),
            line=mapped_choice(line, {"Lines": "pixel", "Billboards": "metres"}, "Value"),
            width=number(line, "Line Width", 0.001, 100),
            plane=mapped_choice(display, {"XY": "xy", "XZ": "xz", "YZ": "yz"}, "Plane"),
        ) | (dict(zip("xyz", point(offset), strict=True)) if any(point(offset)) else {})
        self._note_unsupported(display)

    def _read_tools_and_panels(self, data: Mapping[Any, Any], manager: Mapping[Any, Any]) -> None:
        for tool in map(Properties, map(mapping_or_empty, list_or_empty(manager.get("Tools")))):
            class_name = class_of(tool)
            topic = text(tool, "Topic")
            if class_name not in _TOOLS:
                self._note(f"unsupported tool {one_line(text(tool, 'Class')) or 'without a class'}")
                continue
            if class_name in _PUBLISHING_TOOLS and topic:
                name, default = _PUBLISHING_TOOLS[class_name]
                if (full_name := self._resolve(topic)) != default:
                    self._tools[name] = full_name
            self._note_unsupported(tool, f"tool {class_name}")
        for panel in map(mapping_or_empty, list_or_empty(data.get("Panels"))):
            if class_of(panel) not in _PANELS:
                self._note(f"unsupported panel {one_line(text(panel, 'Class')) or 'without a class'}")
        if list_or_empty(mapping_or_empty(manager.get("Views")).get("Saved")):
            self._note("saved views are ignored; views are saved with the page's layouts")

    def _note(self, line: str) -> None:
        if line and line not in self._notes:
            self._notes.append(line)


def _hidden_parts(parts: Any) -> list[str] | None:
    """Return the names of frames or links that are hidden individually; None if there are none."""
    hidden = (
        name for name, part in mapping_or_empty(parts).items() if boolean(mapping_or_empty(part), "Value") is False
    )
    return [name for name in hidden if isinstance(name, str)][:_MAX_HIDDEN_PARTS] or None


def _display_name(display: Mapping[Any, Any]) -> str:
    name, class_name = text(display, "Name"), class_of(display)
    return one_line(f"{class_name} {name!r}" if name and name != class_name else class_name or "a display")
