"""Videos of web_video_server, played by a browser."""

from __future__ import annotations

import threading
from collections.abc import Callable
from itertools import cycle

import numpy as np
import pytest
from browsing import Browser

from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.node import Node
from pyros1.web.web_video_server.node import start

pytest.importorskip("av", reason="the extra `video` brings it")

COLOUR = """(() => {
    const video = document.querySelector('video');
    if (!video || video.currentTime < 0.5 || video.videoWidth === 0) return null;
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [video.videoWidth, video.videoHeight];
    const context = canvas.getContext('2d');
    context.drawImage(video, 0, 0);
    return [canvas.width, canvas.height, ...context.getImageData(20, 20, 1, 1).data];
})()"""


@pytest.mark.parametrize("stream_type", ["h264", "vp8", "vp9"])
def test_a_browser_plays_the_video(make_node: Callable[..., Node], browser: Browser, stream_type: str) -> None:
    node = Node(
        "web_video_server",
        argv=["_port:=0", "_address:=127.0.0.1"],
        environ=dict(make_node("camera").environ),
        handle_signals=False,
    )
    stop = threading.Event()
    publisher = node.advertise("/image", Image, queue_size=1)
    # Noise, since Chromium reads a video 32 KB at a time, and a plain picture would take long to fill that.
    rng = np.random.default_rng(1)
    pixels = [np.array((200, 40, 90)) + rng.integers(-30, 31, (99, 129, 3)) for _ in range(7)]
    images = [
        Image(height=99, width=129, encoding="rgb8", step=387, data=each.astype("u1").tobytes()) for each in pixels
    ]

    def publish() -> None:
        for image in cycle(images):
            publisher.publish(image)
            if stop.wait(1 / 20):
                return

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        server = start(node)
        page = f"stream_viewer?topic=/image&type={stream_type}&bitrate=8000000&qmin=2&qmax=20"
        browser.open(f"http://127.0.0.1:{server.port}/{page}")
        found = browser.wait(COLOUR)
        browser.driver.get("about:blank")
    finally:
        stop.set()
        thread.join()
        node.shutdown()
    assert found[:2] == [130, 100]
    assert all(abs(value - wanted) < 45 for value, wanted in zip(found[2:5], (200, 40, 90), strict=True))
