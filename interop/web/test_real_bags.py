"""Bags of other programs on the page: those in the folder that ``PYROS1_BAGS`` names; without it, none are.

Feature: bags recorded by other programs, on the page -- rows, messages, curves, frames, 3D without tf; `PYROS1_BAGS`
    names their folder
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from browsing import Browser, Web

import pyros1.bag
from pyros1.bag.errors import BagError
from pyros1.web.links import panel_link

FOLDER = Path(os.environ["PYROS1_BAGS"])
BAGS = sorted([*FOLDER.glob("*.bag"), *FOLDER.glob("*.bag.active")])
SCENE = "document.querySelector('.scene')?.scene"
WORDS = f"[...{SCENE}.displays].map(([key, {{display}}]) => [key, display.problem || display.status])"


def bag(name: str) -> str:
    """Return the path of one of them."""
    assert FOLDER / name in BAGS
    return str(FOLDER / name)


def topics_of(path: Path) -> list[str]:
    try:
        with pyros1.bag.open(path) as opened:
            return sorted(opened.topics)
    except BagError:
        return []


def test_every_bag_is_opened(browser: Browser, start_web: Callable[..., Web]) -> None:
    web = start_web("--bags", str(FOLDER))
    assert BAGS
    browser.open(web.page("bag"))
    for path in BAGS:
        browser.open(panel_link(web.link, "bag", {"path": str(path)}))
        topics = topics_of(path)
        if not topics:
            browser.wait_for_text("This bag is empty")
            continue
        rows = "[...document.querySelectorAll('.timeline .topic')].map((each) => each.textContent).sort()"
        browser.wait(f"JSON.stringify({rows}) === arguments[0]", json.dumps(topics, separators=(",", ":")))
        browser.click(".timeline .name", topics[-1])
        first = "document.querySelector('.topic-message .first')"
        shown = "document.querySelector('.topic-message .twig')"
        browser.wait(f"{first} || {shown}")
        browser.run(f"{first}?.click()")
        browser.wait(shown)


@pytest.mark.parametrize(
    ("name", "curve"),
    [
        ("robot_localization__test_test1.bag", "/imu/data/angular_velocity/z"),
        ("PlotJuggler__fake_joint_state.bag", "/fake_joints_state/position[0]"),
        ("rosbag.js__example-bz2.bag", "/turtle1/pose/x"),
        (
            "jsk_recognition__wrench_sensing_drill_vibration.bag",
            "/bl_force_torque_sensor_driver/output/wrench/wrench/force/x",
        ),
    ],
)
def test_recorded_numbers_are_plotted(browser: Browser, start_web: Callable[..., Web], name: str, curve: str) -> None:
    web = start_web("--bags", str(FOLDER))
    browser.open(panel_link(web.link, "bag", {"path": bag(name), "curves": [curve]}))
    curves = "document.querySelector('.bag')?.bag.chart.curves"
    browser.wait(f"{curves}?.[0]?.whole && [...{curves}[0].lines.values()].some((points) => points.indexOf(1e9) > 50)")
    assert browser.run(f"return {curves}[0].problem") == ""


def test_scans_clouds_and_places_without_tf_are_shown_in_space(
    browser: Browser, web: Web, start_program: Callable[..., Any]
) -> None:
    start_program("bag", "play", "--loop", "--quiet", bag("embag__test_test.bag"))
    topics = ["/luminar_pointcloud", "/base_scan", "/base_pose_ground_truth"]
    browser.open(panel_link(web.link, "scene", {"topics": topics[:1]}))
    browser.wait(f"{SCENE} && /^\\d+ points/.test(Object.fromEntries({WORDS})['{topics[0]}'])")
    browser.wait("document.querySelector('select[aria-label=\"fixed frame\"]').value === ''")
    browser.wait_for_text("(there is no tf)")
    browser.open(panel_link(web.link, "scene", {"topics": topics[1:2]}))
    browser.wait(f"{SCENE} && /^\\d+ points/.test(Object.fromEntries({WORDS})['{topics[1]}'])")


def test_frames_of_a_recording(browser: Browser, web: Web, start_program: Callable[..., Any]) -> None:
    start_program("bag", "play", "--loop", "--quiet", bag("rosbag.js__example.bag"))
    browser.open(web.page("frames"))
    browser.wait_for_text("turtle1")
    browser.wait_for_text("pyros1 bag play --clock")
    browser.open(panel_link(web.link, "plot", {"curves": ["/turtle1/pose/x"]}))
    browser.wait("+document.querySelector('.chip .value')?.textContent > 0")
