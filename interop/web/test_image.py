"""Pictures of every encoding, and compressed ones."""

from __future__ import annotations

import io
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from browsing import Browser, Web
from PIL import Image as Pillow

from pyros1.msgs.sensor_msgs.msg import CompressedImage, Image
from pyros1.msgs.std_msgs.msg import String
from pyros1.observe.image_files import encode
from pyros1.web.links import panel_link

PIXELS = """
    const canvas = document.querySelector('.image canvas');
    return [...canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data];
"""
RED, GREEN, BLUE, WHITE = (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)
FOUR = (RED, GREEN, BLUE, WHITE)


def packed(encoding: str) -> tuple[bytes, int]:
    """Return the rows of a picture of two by two pixels (red, green; blue, white), padded, and its step."""
    size = 1 if "8" in encoding else 2
    order = {"r": 0, "g": 1, "b": 2, "a": 3}
    places = [order[letter] for letter in encoding.rstrip("0123456789")]
    rows = []
    for row in (FOUR[:2], FOUR[2:]):
        values = [(*colour, 255)[place] for colour in row for place in places]
        rows.append(
            b"".join(struct.pack("<B" if size == 1 else "<H", value * (1 if size == 1 else 257)) for value in values)
        )
    return b"".join(row + b"\xaa\xbb" for row in rows), len(rows[0]) + 2


def shown(browser: Browser) -> list[tuple[int, ...]]:
    data = browser.run(PIXELS)
    return [tuple(data[at : at + 3]) for at in range(0, len(data), 4)]


def grey(*values: int) -> list[tuple[int, ...]]:
    return [(value, value, value) for value in values]


CASES: list[tuple[Image, list[tuple[int, ...]]]] = []
for name in ("rgb8", "bgr8", "rgba8", "bgra8", "rgb16", "bgr16", "rgba16", "bgra16"):
    data, step = packed(name)
    CASES.append((Image(width=2, height=2, encoding=name, step=step, data=data), [*FOUR]))
CASES += [
    (Image(width=2, height=1, encoding="mono8", step=2, data=b"\x00\x80"), grey(0, 128)),
    (Image(width=3, height=1, encoding="16UC1", step=6, data=struct.pack("<3H", 1000, 3000, 2000)), grey(0, 255, 128)),
    (Image(width=2, height=1, encoding="mono16", step=4, is_bigendian=1, data=struct.pack(">2H", 5, 9)), grey(0, 255)),
    (
        Image(width=3, height=1, encoding="32FC1", step=12, data=struct.pack("<3f", 0.5, float("nan"), 1.5)),
        [(0, 0, 0), (0, 0, 96), (255, 255, 255)],
    ),
    (Image(width=2, height=2, encoding="bayer_rggb8", step=2, data=bytes([200, 50, 70, 10])), [(200, 60, 10)] * 4),
    (Image(width=2, height=1, encoding="yuv422", step=4, data=bytes([128, 90, 128, 200])), grey(90, 200)),
    (Image(width=2, height=1, encoding="yuv422_yuy2", step=4, data=bytes([90, 128, 200, 128])), grey(90, 200)),
]


@pytest.fixture
def picture(browser: Browser, web: Web, make_node: Callable[..., Any]) -> Callable[[Any], None]:
    """Return a function that publishes a picture, and waits until it is on the page."""
    node = make_node("camera")
    publishers: dict[type, Any] = {}
    count = 0

    def show(message: Any) -> None:
        nonlocal count
        topic = f"camera{len(publishers)}" if type(message) not in publishers else ""
        if topic:
            publishers[type(message)] = node.advertise(topic, type(message), latch=True)
            browser.open(web.page("image"))
            browser.wait(
                f"[...document.querySelectorAll('.panel select option')].some((each) => each.value === '/{topic}')"
            )
            browser.run(
                f"const choice = document.querySelector('.tools select'); choice.value = '/{topic}';"
                "choice.dispatchEvent(new Event('change'));"
            )
        count += 1
        message.header.frame_id = f"frame{count}"
        publishers[type(message)].publish(message)
        browser.wait(f"document.querySelector('.image .status').textContent.includes('frame{count}')")

    return show


def test_every_encoding(browser: Browser, picture: Callable[[Any], None]) -> None:
    for message, colours in CASES:
        picture(message)
        found = shown(browser)
        close = all(
            abs(a - b) <= 1 for one, two in zip(found, colours, strict=True) for a, b in zip(one, two, strict=True)
        )
        assert close, (message.encoding, found, colours)


def test_the_limits_of_depth(browser: Browser, picture: Callable[[Any], None]) -> None:
    picture(Image(width=3, height=1, encoding="16UC1", step=6, data=struct.pack("<3H", 0, 500, 1000)))
    assert [pixel[0] for pixel in shown(browser)] == [0, 128, 255]
    assert "object" not in browser.run("return document.querySelector('.tools').innerText")
    browser.type("[aria-label='least value']", "500")
    browser.type("[aria-label='greatest value']", "600")
    picture(Image(width=3, height=1, encoding="16UC1", step=6, data=struct.pack("<3H", 0, 500, 1000)))
    assert [pixel[0] for pixel in shown(browser)] == [0, 0, 255]


@pytest.mark.parametrize("form", ["png", "jpeg"])
def test_compressed(browser: Browser, picture: Callable[[Any], None], form: str) -> None:
    file = io.BytesIO()
    Pillow.new("RGB", (8, 8), (250, 20, 30)).save(file, form)
    picture(CompressedImage(format=form, data=file.getvalue()))
    found = shown(browser)
    assert len(found) == 64
    assert all(abs(a - b) < 6 for pixel in found for a, b in zip(pixel, (250, 20, 30), strict=True))


def test_depths_that_are_compressed_look_like_those_that_are_not(
    browser: Browser, picture: Callable[[Any], None]
) -> None:
    """A browser alone shows the upper bytes: nearly black."""
    file = encode(np.array([[1000, 2000, 3000]], np.uint16), "png")
    picture(CompressedImage(format="16UC1; png compressed ", data=file))
    assert [pixel[0] for pixel in shown(browser)] == [0, 128, 255]
    browser.wait("document.querySelector('.image .status').textContent.includes('1000 … 3000')")
    picture(CompressedImage(format="16UC1; compressedDepth png", data=bytes(12) + file))
    assert [pixel[0] for pixel in shown(browser)] == [0, 128, 255]
    file = encode(np.array([[150, 0, 100]], np.uint16), "png")
    picture(CompressedImage(format="32FC1; compressedDepth", data=struct.pack("<iff", 0, 100.0, 50.0) + file))
    assert shown(browser) == [(0, 0, 0), (0, 0, 96), (255, 255, 255)]
    assert "1 … 2" in browser.run("return document.querySelector('.image .status').textContent")


@pytest.mark.parametrize(
    ("message", "said"),
    [
        (Image(width=2, height=2, encoding="rgb8", step=6, data=b"123"), "too few"),
        (Image(width=4, height=1, encoding="rgb8", step=4, data=bytes(100)), "but step is 4"),
        (Image(width=2, height=2, encoding="odd<b>", step=6, data=bytes(100)), "the encoding odd<b> is not supported"),
        (Image(width=4_000_000_000, height=4_000_000_000, encoding="mono8", step=1), "too large"),
        (Image(encoding="rgb8"), "0 x 0 pixels"),
        (CompressedImage(format="jpeg", data=b"no picture"), "cannot show images of the format jpeg"),
        (String("x"), "this is not an image topic, its type is std_msgs/String"),
    ],
)
def test_what_cannot_be_shown(
    browser: Browser, web: Web, make_node: Callable[..., Any], message: Any, said: str
) -> None:
    make_node("camera").advertise("camera", type(message), latch=True).publish(message)
    browser.open(panel_link(web.link, "image", {"topic": "/camera"}))
    browser.wait_for_text(said)


def test_what_came_in_a_pause_and_how_often_pictures_come(
    browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    publisher = make_node("camera").advertise("camera", Image, latch=True)
    black, white = (Image(width=1, height=1, encoding="mono8", step=1, data=bytes([value])) for value in (0, 255))
    publisher.publish(black)
    browser.open(panel_link(web.link, "image", {"topic": "/camera"}))
    pixel = "document.querySelector('.image canvas').getContext('2d').getImageData(0, 0, 1, 1).data[0]"
    browser.wait(f"document.querySelector('.image canvas')?.width === 1 && {pixel} === 0")
    browser.click("button", "Pause")
    publisher.publish(white)
    browser.wait("/[1-9][0-9.]* Hz/.test(document.querySelector('.image .status').textContent)")
    assert browser.run(f"return {pixel}") == 0
    browser.click("button", "Resume")
    browser.wait(f"{pixel} === 255")  # another one will not come
    browser.run("const now = performance.now.bind(performance); performance.now = () => now() + 10000")
    browser.wait_for_text("0 Hz")


def test_a_picture_is_made_larger_and_dragged(browser: Browser, picture: Callable[[Any], None]) -> None:
    picture(Image(width=4, height=4, encoding="rgb8", step=12, data=bytes(48)))
    assert not browser.run("return document.querySelector('.limit').checkVisibility()")  # it has no range
    box = "document.querySelector('.image canvas').getBoundingClientRect()"
    frame = browser.run("return document.querySelector('.image .frame').getBoundingClientRect().toJSON()")
    x, y = frame["x"] + frame["width"] / 2 + 50, frame["y"] + frame["height"] / 2 + 50
    wide, place = browser.run(f"return [{box}.width, ({x} - {box}.left) / {box}.width]")

    def mouse(kind: str, x: float, y: float, **more: Any) -> None:
        browser.driver.execute_cdp_cmd("Input.dispatchMouseEvent", {"type": kind, "x": x, "y": y, **more})

    under = "document.querySelector('.image .status').textContent.split(': ')[1]"
    mouse("mouseMoved", x, y)
    browser.wait(f"{under} === '0 0 0'")
    picture(Image(width=4, height=4, encoding="rgb8", step=12, data=bytes([9]) * 48))
    assert browser.run(f"return {under}") == "9 9 9"  # what is under the mouse is told of each picture
    mouse("mouseWheel", x, y, deltaX=0, deltaY=-200)
    browser.wait(f"{box}.width > {wide} * 1.2")
    assert browser.run(f"return ({x} - {box}.left) / {box}.width") == pytest.approx(place, abs=0.01)  # it stays there
    left = browser.run(f"return {box}.left")
    mouse("mousePressed", x, y, button="left", buttons=1, clickCount=1)
    mouse("mouseMoved", x + 30, y, button="left", buttons=1)
    mouse("mouseReleased", x + 30, y, button="left", clickCount=1)
    browser.wait(f"Math.abs({box}.left - {left} - 30) < 1")
    browser.run("document.querySelector('.image .frame').dispatchEvent(new MouseEvent('dblclick'))")
    browser.wait(f"{box}.width === {wide}")
    browser.click(".tools button", "Pause")
    browser.choose(".tools select", "/camera0")  # of a topic that is chosen, something is seen
    browser.wait("document.querySelector('.tools button').textContent === 'Pause'")


def test_two_fingers_make_a_picture_larger(browser: Browser, picture: Callable[[Any], None]) -> None:
    picture(Image(width=4, height=4, encoding="mono8", step=4, data=bytes(16)))
    wide = browser.run("return document.querySelector('.image canvas').getBoundingClientRect().width")
    browser.run(
        "const frame = document.querySelector('.image .frame'), {left, top} = frame.getBoundingClientRect();"
        "frame.setPointerCapture = () => {};"
        "const at = (kind, pointerId, x) => frame.dispatchEvent(new PointerEvent(kind, {"
        "  pointerId, pointerType: 'touch', clientX: left + x, clientY: top + 200}));"
        "at('pointerdown', 1, 200); at('pointerdown', 2, 300); at('pointermove', 2, 400); at('pointerup', 1, 200);"
    )
    browser.wait("document.querySelector('.image canvas').getBoundingClientRect().width === 2 * arguments[0]", wide)


def test_a_picture_that_cannot_be_shown_is_not_called_absent(
    browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    publisher = make_node("camera").advertise("picture", Image, latch=True)
    browser.open(panel_link(web.link, "image", {"topic": "/picture"}))
    browser.wait_for_text("No message has arrived on /picture since this panel was opened.")
    publisher.publish(Image(width=1, height=1, encoding="rgb9", step=3, data=b"123"))
    browser.wait_for_text("What arrives on /picture cannot be shown: the encoding rgb9 is not supported")
    publisher.publish(Image(width=1, height=1, encoding="bayer_rggb16", step=2, data=b"12"))
    browser.wait("getComputedStyle(document.querySelector('.image .hint')).display === 'none'")
