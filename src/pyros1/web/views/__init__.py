"""Views: each shows one thing on a page, again and again. A view is a class in a file of its own, listed here."""

from __future__ import annotations

from importlib import import_module

from pyros1.web.views.view import View

_HOMES = {
    "system": "SystemView",
    "console": "ConsoleView",
    "plot": "PlotView",
    "message": "MessageView",
    "rates": "RatesView",
    "publish": "PublishView",
    "param": "ParamView",
    "params": "ParamsView",
    "reconfigure": "ReconfigureView",
    "action": "ActionView",
    "bag_file": "BagFileView",
    "bag_timeline": "BagTimelineView",
    "bag_cursor": "BagCursorView",
    "bag_pictures": "BagPicturesView",
    "bag_plot": "BagPlotView",
    "bag_play": "BagPlayView",
    "bag_recording": "BagRecordingView",
    "frames": "FramesView",
    "scene_frames": "SceneFramesView",
    "scene_interactive": "SceneInteractiveView",
    "scene_topic": "SceneTopicView",
    "image": "ImageView",
    "joints": "JointsView",
    "launches": "LaunchesView",
    "launch_log": "LaunchLogView",
}
NAMES = frozenset(_HOMES)
"""Names of the views."""


def view_class(name: str) -> type[View]:
    """Return the class of a view; its name is one of `NAMES`."""
    found: type[View] = getattr(import_module(f"pyros1.web.views.{name}"), _HOMES[name])
    return found
