"""Views: each keeps part of a page up to date. A view is a class in a module of its own, listed here."""

from __future__ import annotations

from importlib import import_module

from pyros1.web.views.view import View

_CLASS_PATHS = {
    "system": "system.SystemView",
    "console": "console.ConsoleView",
    "plot": "plot.PlotView",
    "message": "message.MessageView",
    "rates": "rates.RatesView",
    "publish": "publish.PublishView",
    "param": "param.ParamView",
    "params": "params.ParamsView",
    "reconfigure": "reconfigure.ReconfigureView",
    "action": "action.ActionView",
    "bag_file": "bag.file.BagFileView",
    "bag_timeline": "bag.timeline.BagTimelineView",
    "bag_cursor": "bag.cursor.BagCursorView",
    "bag_pictures": "bag.pictures.BagPicturesView",
    "bag_plot": "bag.plot.BagPlotView",
    "bag_play": "bag.play.BagPlayView",
    "bag_recording": "bag.recording.BagRecordingView",
    "frames": "frames.FramesView",
    "scene_camera": "scene.camera.SceneCameraView",
    "scene_depth": "scene.depth.SceneDepthView",
    "scene_frames": "scene.frames.SceneFramesView",
    "scene_interactive": "scene.interactive.SceneInteractiveView",
    "scene_topic": "scene.topic.SceneTopicView",
    "gamepad": "gamepad.GamepadView",
    "image": "image.ImageView",
    "joints": "joints.JointsView",
    "launches": "launches.LaunchesView",
    "launch_log": "launch_log.LaunchLogView",
    "turtles": "turtles.TurtlesView",
}
VIEW_NAMES = frozenset(_CLASS_PATHS)
"""Names of all views."""


def view_class(name: str) -> type[View]:
    """Load and return the class of the view with the given name, which must be in `VIEW_NAMES`."""
    module, _, class_name = _CLASS_PATHS[name].rpartition(".")
    cls: type[View] = getattr(import_module(f"pyros1.web.views.{module}"), class_name)
    return cls
