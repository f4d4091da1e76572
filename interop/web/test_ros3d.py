"""A page of another site that shows the robot with ros3djs (npm: ros3d), through the server's port.

Feature: ros3djs pages, with frames from `pyros1 run tf2_web_republisher tf2_web_republisher` -- point clouds, scans,
    maps, markers
"""

from __future__ import annotations

import functools
import http.server
import math
import os
import shutil
import subprocess
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browsing import Browser, Web

from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.nav_msgs.msg import OccupancyGrid
from pyros1.msgs.sensor_msgs.msg import LaserScan, PointCloud2, PointField
from pyros1.msgs.visualization_msgs.msg import Marker, MarkerArray
from pyros1.tf import StaticTransformBroadcaster
from pyros1.topic_tools.tf2_web_republisher import Republisher

PAGE = """<!DOCTYPE html><meta charset="utf-8"><title>ros3d</title><link rel="icon" href="data:,"><div id="view"></div>
<script src="node_modules/eventemitter2/lib/eventemitter2.js"></script>
<script src="node_modules/roslib/build/roslib.min.js"></script>
<script src="node_modules/ros3d/build/ros3d.min.js"></script>
<script>
const ros = new ROSLIB.Ros({ url: decodeURIComponent(location.hash.slice(1)) });
const viewer = new ROS3D.Viewer({ divID: "view", width: 600, height: 400, antialias: true });
const tfClient = new ROSLIB.TFClient({ ros, fixedFrame: "map", angularThres: 0.001, transThres: 0.001, rate: 20 });
const common = { ros, tfClient, rootObject: viewer.scene };
const shown = {
  cloud: new ROS3D.PointCloud2({ ...common, topic: "/cloud", max_pts: 100, material: { size: 0.2 } }),
  scan: new ROS3D.LaserScan({ ...common, topic: "/scan", max_pts: 100 }),
  grid: new ROS3D.OccupancyGridClient({ ...common, topic: "/grid" }),
  markers: new ROS3D.MarkerArrayClient({ ...common, topic: "/markers" }),
};
const place = (node) => node && [node.position.x, node.position.y].map((each) => +each.toFixed(3));
window.seen = () => ({
  cloud: shown.cloud.points.geom && shown.cloud.points.geom.drawRange.count,
  scan: shown.scan.points.geom && shown.scan.points.geom.drawRange.count,
  base: place(shown.cloud.points.sn),
  grid: shown.grid.currentGrid && shown.grid.currentGrid.geometry.parameters.width,
  markers: Object.values(shown.markers.markers).map(place),
});
</script>
"""


class _Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture(scope="session")
def other_site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a site with a page of ros3d."""
    if not shutil.which("npm"):
        if os.environ.get("PYROS1_REQUIRE_STOCK"):
            pytest.fail("npm is missing: interop/setup installs it")
        pytest.skip("npm is not installed")
    folder = tmp_path_factory.mktemp("ros3d")
    done = subprocess.run(
        ["npm", "install", "--no-audit", "--no-fund", "--ignore-scripts", "ros3d@1.1.0", "roslib@1"],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=110,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    (folder / "page.html").write_text(PAGE)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(_Quiet, directory=str(folder))) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://localhost:{server.server_port}"
        server.shutdown()
        thread.join()


def publish(node: Any) -> None:
    """Publish what the page shows, once, latched."""
    frame = TransformStamped(child_frame_id="base")
    frame.header.frame_id = "map"
    frame.transform.translation.x = 2.0
    frame.transform.rotation.w = 1.0
    StaticTransformBroadcaster(node).send_transform(frame)
    fields = [PointField(name, 4 * index, 7, 1) for index, name in enumerate("xyz")]
    points = np.array([[1, 2, 3], [4, 5, 6], [7, 8, 9]], np.float32)
    cloud = PointCloud2(height=1, width=3, fields=fields, point_step=12, row_step=36, data=points.tobytes())
    scan = LaserScan(angle_increment=0.1, range_max=10.0, ranges=[1.0, 2.0, math.inf, 3.0])
    grid = OccupancyGrid(data=[0, 100, -1, 50, 0, 0])
    grid.info.width, grid.info.height, grid.info.resolution, grid.info.origin.orientation.w = 3, 2, 1.0, 1.0
    marker = Marker(ns="a", id=1, type=Marker.CUBE)
    marker.scale.x = marker.scale.y = marker.scale.z = marker.color.a = marker.pose.orientation.w = 1.0
    for message in (cloud, scan, marker):
        message.header.frame_id = "base"
    grid.header.frame_id = "map"
    messages = {"cloud": cloud, "scan": scan, "grid": grid, "markers": MarkerArray([marker])}
    for name, message in messages.items():
        node.advertise(name, type(message), latch=True).publish(message)


def test_ros3d(
    browser: Browser, start_web: Callable[..., Web], other_site: str, make_node: Callable[..., Any], tmp_path: Path
) -> None:
    Republisher(make_node("tf2_web_republisher"))
    publish(make_node("robot"))
    web = start_web("--origin", other_site)
    browser.open(f"{other_site}/page.html#{web.link.replace('http://', 'ws://')}")
    for name, wanted in {"cloud": 3, "scan": 3, "base": [2, 0], "grid": 3, "markers": [[2, 0]]}.items():
        browser.wait("JSON.stringify(seen()[arguments[0]]) === JSON.stringify(arguments[1])", name, wanted)
    picture = tmp_path / "ros3d.png"
    browser.picture(picture)
    browser.complaints()  # old three.js warns of many things
