"""Each panel with recorded data: a bag of a small robot that is played into the graph, again and again."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from browsing import Browser, Web

import pyros1.bag
from pyros1.ground.timing import Time
from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.msgs.sensor_msgs.msg import Image, LaserScan
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.web.links import panel_link

SCENE = "document.querySelector('.scene')?.scene"
WALL = """
    const canvas = document.querySelector('.image canvas');
    return canvas && [...canvas.getContext('2d').getImageData(0, 0, 1, 1).data].slice(0, 3).join();
"""


@pytest.fixture
def recorded(tmp_path: Path, start_program: Callable[..., Any]) -> None:
    """A bag of 5 s with everything that panels show is played in a loop."""
    path = tmp_path / "robot.bag"
    with pyros1.bag.open(path, "w") as bag:
        for step in range(100):
            stamp = Time(1_700_000_000 + step // 20, step % 20 * 50_000_000)
            frame = TransformStamped(child_frame_id="base")
            frame.header.frame_id, frame.header.stamp = "odom", stamp
            frame.transform.translation.x, frame.transform.rotation.w = step / 20, 1.0
            scan = LaserScan(angle_increment=0.1, range_max=10.0, ranges=[2.0] * 50)
            scan.header.frame_id, scan.header.stamp = "base", stamp
            log = Log(level=4, name="/driver", msg=f"step {step}")
            log.header.stamp = stamp
            picture = Image(height=2, width=2, step=6, encoding="rgb8", data=bytes([250, 120, 10] * 4))
            picture.header.stamp = stamp
            bag.write("/tf", TFMessage([frame]), stamp)
            bag.write("/scan", scan, stamp)
            bag.write("/rosout", log, stamp)
            bag.write("/camera", picture, stamp)
            bag.write("/wave", Float64(math.sin(step / 10) + 5), stamp)
    start_program("bag", "play", "--loop", "--quiet", str(path))


@pytest.mark.usefixtures("recorded")
def test_every_panel_shows_recorded_data(browser: Browser, web: Web) -> None:
    browser.open(web.page("graph"))
    browser.wait("document.querySelector('.graph')?.graph?.model?.boxes.some((box) => box.id.includes('/play'))")
    browser.open(web.page("console"))
    browser.wait_for_text("step 50")
    browser.wait_for_text("/driver")
    browser.open(panel_link(web.link, "plot", {"curves": ["/wave/data"]}))
    browser.wait("+document.querySelector('.chip .value')?.textContent > 3.9")
    browser.open(panel_link(web.link, "image", {"topic": "/camera"}))
    browser.wait(f"(() => {{{WALL}}})() === '250,120,10'")
    browser.open(web.page("frames"))
    browser.wait("document.querySelector('.frames tbody')?.innerText.includes('base')")
    browser.open(panel_link(web.link, "scene", {"fixed": "odom", "topics": ["/scan"]}))
    browser.wait(f"{SCENE}?.displays.get('/scan')?.display.status === '50 points'")
    browser.open(web.page("topics"))
    browser.wait("[...document.querySelectorAll('.line')].some((line) => line.dataset.key === '/wave')")
    browser.open(web.page("nodes"))
    browser.wait("document.body.innerText.includes('/play_')")
