"""The plot, with the minimal simulator of the tutorial.

Feature: the robot in a browser -- a plot of the minimal simulator, in Chromium
"""

from __future__ import annotations

import base64
import itertools
import json
import math
from collections.abc import Callable
from typing import Any

from browsing import Browser, Web

from pyros1.msgs.std_msgs.msg import Float64
from pyros1.web.links import panel_link

SHOWN = """Object.fromEntries([...document.querySelectorAll('.chip')].map(
    (chip) => [chip.querySelector('.name').textContent, chip.querySelector('.value').textContent]))"""
POINTS = """
    const curve = document.querySelector('.plot').plot.curves[0].points.get(-1);
    return [curve.times, curve.values].map((each) => [...each.subarray(curve.start, curve.end)]);
"""


def add(browser: Browser, text: str) -> None:
    browser.type(".plot input, .tools form input", text)
    browser.click(".tools form button", "Add")


def test_the_simulators_approach_is_exponential(
    browser: Browser, web: Web, start_program: Callable[..., Any], make_node: Callable[..., Any]
) -> None:
    start_program("launch", "minimal_nodes", "minimal_simulator.launch")
    node: Any = make_node("commander")
    publisher = node.advertise("vel_cmd", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    for attempt in range(5):
        browser.open(web.page("plot"))
        add(browser, "/velocity/data,/force_cmd/data")
        browser.wait(f"'/velocity/data' in {SHOWN} && document.querySelector('.uplot canvas')")
        browser.wait(f"Math.abs({SHOWN}['/velocity/data']) < 0.001")
        publisher.publish(Float64(1.0))
        browser.wait(f"{SHOWN}['/velocity/data'] > 0.999")
        publisher.publish(Float64(0.0))
        browser.wait(f"Math.abs({SHOWN}['/velocity/data']) < 0.001")
        try:
            check_exponential(*browser.run(POINTS))
            break
        except AssertionError:
            if attempt == 4:  # a machine may let a program stand still for a moment, but not every time
                raise


def check_exponential(times: list[float], values: list[float]) -> None:
    """The controller's force is proportional to the error, so the error shrinks by equal factors in equal times."""
    assert times == sorted(times)
    rising = [(t, v) for t, v in zip(times, values, strict=True) if 0.1 < v < 0.9]
    assert rising and max(values) <= 1.0 + 1e-6
    up = [pair for pair in rising if pair[0] < times[values.index(max(values))]]
    slope = [(math.log(1 - v), t) for t, v in up]
    (first, begin), (last, end) = slope[0], slope[-1]
    rate = (first - last) / (end - begin)
    for log, t in slope:
        assert abs((first - log) - rate * (t - begin)) < 0.3, json.dumps([log, t])


def test_a_wrong_field_says_so_and_others_go_on(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    publisher = make_node("talker").advertise("numbers", "std_msgs/Int32MultiArray", latch=True)
    message = publisher.type(data=[3, 4, 5])
    publisher.publish(message)
    browser.open(web.page("plot"))
    for text in ("/numbers/data[1]", "numbers/data[0:2]", "/numbers: m.data[2] * 10", "/numbers/dat", "/nothing/here"):
        add(browser, text)
    browser.wait(f"{SHOWN}['/numbers/data[1]'] === '4' && {SHOWN}['/numbers/data[0:2]'] === '3  4'")
    browser.wait(f"{SHOWN}['/numbers: m.data[2] * 10'] === '50'")
    browser.wait(f"{SHOWN}['/numbers/dat'].includes(\"no field 'dat'\")")
    make_node("quiet").advertise("quiet", Float64)
    add(browser, "/quiet/data")
    for name, text in (("/nothing/here", "no such topic yet"), ("/quiet/data", "no message yet")):
        browser.wait(f"{SHOWN}[arguments[0]] === arguments[1]", name, text)
    looks = browser.run("return [...document.querySelectorAll('.chip .value')].map((each) => each.className)")
    said = {"no field": "value mono wrong", "yet": "value mono muted"}
    texts = browser.run(f"return Object.values({SHOWN})")
    assert looks == [next((said[word] for word in said if word in text), "value mono") for text in texts]


def test_curves_are_in_the_link_and_kept(browser: Browser, web: Web) -> None:
    browser.open(web.page("plot"))
    add(browser, "/a/data")
    browser.wait("document.querySelectorAll('.chip').length === 1")
    chart = "document.querySelector('.plot').plot.charts[0]"
    browser.wait(f"(window.before = {chart})")
    browser.prefer("dark")  # as systems do at sunset
    browser.wait(f"{chart} !== before")
    browser.prefer("")
    browser.click("#bar button", "Link")
    link = browser.wait("location.href.includes('=') && location.hash.length > 10 && location.href")
    browser.run("localStorage.clear()")
    browser.open(link)
    browser.wait("document.querySelector('.chip .name')?.textContent === '/a/data'")


def test_one_field_against_another(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    publisher = make_node("walker").advertise("pose", "geometry_msgs/Pose2D")
    browser.open(web.page("plot"))
    browser.click(".tools button", "XY")
    browser.wait_for_text("the second against the first")
    add(browser, "/pose/x:y")
    assert publisher.wait_for_subscribers(timeout=20)
    chart = "document.querySelector('.plot').plot.charts[0]"
    browser.wait("document.querySelector('.chip .name')?.textContent === '/pose x, y'")
    for number in range(101):
        publisher.publish(publisher.type(x=4 * math.cos(number * math.pi / 50), y=math.sin(number * math.pi / 50)))
    browser.wait(f"{chart}?.trails?.[0]?.xs.length === 101")
    trail = browser.run(f"const t = {chart}.trails[0]; return [[...t.xs], [...t.ys]]")
    for number, (x, y) in enumerate(zip(*trail, strict=True)):
        assert (x, y) == (4 * math.cos(number * math.pi / 50), math.sin(number * math.pi / 50))
    assert browser.run(f"return {chart}.plot.axes.map((axis) => axis.label)") == ["/pose/x", "/pose/y"]
    # Equal axes: a unit has as many pixels on both.
    units = f"""(() => {{ const c = {chart}; const {{ x, y }} = c.shown; const over = c.plot.over;
        return over.clientWidth / (x[1] - x[0]) / (over.clientHeight / (y[1] - y[0])); }})()"""
    assert abs(browser.run(f"return {units}") - 1) < 1e-6
    browser.click(".tools button", "Pause")
    browser.click(".tools button", "1:1")
    browser.wait(f"Math.abs({units} - 1) > 0.1")
    # The cursor finds the nearest point, here that at the left end.
    browser.wait(f"{chart}.trails[0]?.xs.length === 101")
    browser.run(
        f"const c = {chart}; const box = c.plot.over.getBoundingClientRect();"
        "c.plot.over.dispatchEvent(new MouseEvent('mousemove', {bubbles: true,"
        "clientX: box.left + c.plot.valToPos(-4, 'x') + 6, clientY: box.top + c.plot.valToPos(0, 'y') - 2}));"
    )
    browser.wait(f"({SHOWN}['/pose x, y'] || '').startsWith('-4, ')")
    browser.click("#bar button", "Link")
    link = browser.wait("location.hash.length > 10 && location.href")
    browser.run("localStorage.clear()")
    browser.open(link)
    browser.wait("document.querySelector('.chip .name')?.textContent === '/pose x, y'")
    browser.click(".tools button", "XY")
    browser.wait(f"'/pose/x' in {SHOWN} && '/pose/y' in {SHOWN}")
    browser.click(".tools button", "XY")
    browser.click(".chip button[aria-label^=remove]")
    browser.wait_for_text("the second against the first")


def test_values_at_the_cursor_and_what_is_saved(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    publisher = make_node("talker").advertise("number", Float64)
    browser.open(web.page("plot"))
    add(browser, "/number/data")
    assert publisher.wait_for_subscribers(timeout=20)
    for number in range(1, 6):
        publisher.publish(Float64(number))
        browser.wait(f"{SHOWN}['/number/data'] === arguments[0]", str(number))
    browser.click(".tools button", "Pause")
    times, values = browser.run(POINTS)
    assert values == [1.0, 2.0, 3.0, 4.0, 5.0]
    move = """
        const {plot} = document.querySelector('.plot'); const [chart] = plot.charts;
        const box = chart.over.getBoundingClientRect();
        chart.over.dispatchEvent(new MouseEvent(arguments[1], {bubbles: true,
            clientX: box.left + chart.valToPos(arguments[0], 'x'), clientY: box.top + 50}));
    """
    # Again and again: the chart may move once more after it was paused. A cursor is at a whole pixel.
    nearest = f"""(() => {{
        {move}
        const off = arguments[2].map((time) => Math.abs(time - chart.posToVal(chart.cursor.left, 'x')));
        return {SHOWN}['/number/data'] === String(off.indexOf(Math.min(...off)) + 1);
    }})()"""
    for begin, end in itertools.pairwise(times):
        for part in (0.3, 0.7):
            browser.wait(nearest, begin + part * (end - begin), "mousemove", times)
    browser.run(move, times[0], "mouseleave")
    browser.wait(f"{SHOWN}['/number/data'] === '5'")

    rows = [line.split(",") for line in browser.saved("button", "CSV").decode().splitlines()]
    assert rows[0] == ["curve", "time", "value"]
    assert [(name, float(time), float(value)) for name, time, value in rows[1:]] == [
        ("/number/data", time, value) for time, value in zip(times, values, strict=True)
    ]
    picture = browser.saved("button", "PNG")
    browser.run(
        "const bytes = Uint8Array.from(atob(arguments[0]), (each) => each.charCodeAt(0));"
        "createImageBitmap(new Blob([bytes])).then((map) => {"
        "const canvas = new OffscreenCanvas(map.width, map.height); const context = canvas.getContext('2d');"
        "context.drawImage(map, 0, 0); const {data} = context.getImageData(0, 0, map.width, map.height); let n = 0;"
        "for (let i = 0; i < data.length; i += 4) n += [0x1c, 0x7e, 0xd6].every((part, at) => data[i + at] === part);"
        "window.found = [map.width, map.height, n]; });",
        base64.b64encode(picture).decode(),
    )
    width, height, blue = browser.wait("window.found")
    assert width > 300 and height > 100
    assert blue > 20  # the curve
    browser.choose(".tools select[aria-label=period]", "5")  # it stays paused
    assert browser.run("const {range} = document.querySelector('.plot').plot; return range[1] - range[0]") == 5
    assert browser.run("return document.querySelector('.tools button[aria-pressed=true]').textContent") == "Resume"


CHART = "document.querySelector('.plot').plot.charts[0]"
DRAG = """
    const [kind, more, path] = arguments; const chart = document.querySelector('.plot').plot.charts[0];
    const box = chart.over.getBoundingClientRect(); chart.over.setPointerCapture = () => {};
    for (const [type, id, x, y] of path) chart.over.dispatchEvent(new PointerEvent(type, { bubbles: true, button: 0,
        pointerId: id, pointerType: kind, clientX: box.left + x, clientY: box.top + y, ...more }));
    const { x, y } = chart.scales; return [document.querySelector('.plot').plot.range, chart.high];
"""


def test_fingers_and_the_mouse_move_and_zoom(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    make_node("talker").advertise("number", Float64, latch=True).publish(4.0)
    browser.resize(390, 844)
    browser.open(web.page("plot"))
    add(browser, "/number/data")
    browser.wait(f"{SHOWN}['/number/data'] === '4' && {CHART}?.over.clientWidth > 100")
    browser.click(".tools button", "Pause")
    wide = browser.run(f"return {CHART}.over.clientWidth")
    begin, end = browser.run("return document.querySelector('.plot').plot.range")
    finger = [["pointerdown", 1, 100, 100], ["pointermove", 1, 140, 100], ["pointerup", 1, 140, 100]]
    (left, right), high = browser.run(DRAG, "touch", {}, finger)
    assert abs((begin - left) / (end - begin) - 40 / wide) < 1e-6 and abs(right - left - (end - begin)) < 1e-6
    assert high is None
    (left, _), _ = browser.run(DRAG, "mouse", {}, finger)
    assert abs((begin - left) / (end - begin) - 40 / wide) < 1e-6, "a mouse alone selects"
    (left, _), _ = browser.run(DRAG, "mouse", {"shiftKey": True}, finger)
    assert abs((begin - left) / (end - begin) - 80 / wide) < 1e-6
    two = [["pointerdown", 1, 60, 100], ["pointerdown", 2, 120, 105], ["pointermove", 2, 180, 105]]
    (left, right), high = browser.run(DRAG, "touch", {}, [*two, ["pointerup", 1, 60, 100], ["pointerup", 2, 180, 105]])
    assert abs((right - left) / (end - begin) - 0.5) < 1e-6, "twice as far apart, half as much is seen"
    assert high is None
    two = [
        ["pointerdown", 1, 60, 60],
        ["pointerdown", 2, 60, 120],
        ["pointermove", 2, 60, 180],
        ["pointerup", 1, 60, 60],
    ]
    _, high = browser.run(DRAG, "touch", {}, [*two, ["pointerup", 2, 60, 180]])
    assert high and high[0] < high[1]
    browser.run(f"{CHART}.over.dispatchEvent(new MouseEvent('dblclick'))")
    browser.wait(f"{CHART}.high === null && document.querySelector('.plot').plot.range === null")


def test_the_wheel_zooms_the_height_and_the_cursors_time_is_said(
    browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    make_node("talker").advertise("number", Float64, latch=True).publish(4.0)
    browser.open(web.page("plot"))
    add(browser, "/number/data")
    browser.wait(f"{SHOWN}['/number/data'] === '4' && {CHART}?.scales.y.max > 4")
    browser.click(".tools button", "Pause")
    before = browser.run(f"return {CHART}.scales.y.max - {CHART}.scales.y.min")
    event = "{deltaY: -1, ctrlKey: true, bubbles: true, cancelable: true}"
    browser.run(f"{CHART}.over.dispatchEvent(new WheelEvent('wheel', {event}))")
    browser.wait(f"Math.abs({CHART}.scales.y.max - {CHART}.scales.y.min - arguments[0] / 1.2) < 1e-6", before)
    time = browser.run(
        f"const {{ over }} = {CHART}; const box = over.getBoundingClientRect();"
        "for (const kind of ['mouseenter', 'mousemove']) over.dispatchEvent(new MouseEvent(kind,"
        " {clientX: box.left + 100, clientY: box.top + 50, bubbles: true}));"
        f"return {CHART}.posToVal(100, 'x') - document.querySelector('.plot').plot.origin"
    )
    said = browser.wait("document.querySelector('.when:not([hidden])')?.textContent")
    assert abs(float(said.partition(" s")[0]) - time) < 0.1  # within some pixels


def test_a_box_zooms_time_and_the_height_of_its_chart(
    browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    publisher = make_node("talker").advertise("numbers", "std_msgs/Float64MultiArray", latch=True)
    publisher.publish(publisher.type(data=[1795706847.0, 2.0]))
    browser.open(panel_link(web.link, "plot", {"curves": ["/numbers/data"], "stacked": True, "paused": True}))
    charts = "document.querySelector('.plot')?.plot.charts"
    browser.wait(f"{charts}?.length === 2 && {charts}[1].over.clientWidth > 200 && {charts}[1].scales.x.max")
    lefts = f"{charts}.map((each) => each.over.getBoundingClientRect().left)"
    browser.wait(f"new Set({lefts}).size === 1")  # times are below each other, however wide the numbers are
    box = browser.run(f"return {charts}[1].over.getBoundingClientRect().toJSON()")
    places = [(box["x"] + 100, box["y"] + 60), (box["x"] + 250, box["y"] + 160)]
    for kind, (x, y) in (("mousePressed", places[0]), ("mouseMoved", places[1]), ("mouseReleased", places[1])):
        at = {"x": x, "y": y, "button": "left", "clickCount": 1}
        browser.driver.execute_cdp_cmd("Input.dispatchMouseEvent", {"type": kind, **at})
    browser.wait(f"{charts}[1].high")
    assert browser.run(f"return {charts}[0].high") is None
    begin, end = browser.run("return document.querySelector('.plot').plot.range")
    assert abs((end - begin) / 20 - 150 / box["width"]) < 0.02


def test_twenty_curves_are_told_apart_and_named_in_the_picture(
    browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    publisher = make_node("talker").advertise("numbers", "std_msgs/Float64MultiArray", latch=True)
    publisher.publish(publisher.type(data=[float(x) for x in range(20)]))
    browser.resize(390, 844)
    browser.open(web.page("plot"))
    for number in range(20):
        add(browser, f"/numbers/data[{number}]")
    lines = "document.querySelector('.plot').plot.lines"
    browser.wait(f"{lines}.length === 20")
    look = ".map(({ colour, dash }) => JSON.stringify([colour, dash]))"
    assert len({*browser.run(f"return {lines}{look}")}) == 20
    browser.wait("document.querySelectorAll('.chip').length === 20 && document.querySelector('.charts canvas')")
    assert browser.run(f"return {CHART}.over.clientHeight") > 300, "the legend leaves room"
    size = browser.run("const c = document.querySelector('.charts canvas'); return [c.width, c.height]")
    png = browser.saved("button", "PNG")
    width, height = (int.from_bytes(png[at : at + 4], "big") for at in (16, 20))
    assert width == size[0] and height > size[1] + 100
    pairs = [["/numbers/data[0]", f"/numbers/data[{number}]"] for number in range(20)]
    browser.open(panel_link(web.link, "plot", {"xy": True, "pairs": pairs}))
    trails = "document.querySelector('.plot')?.plot.pairs.trails()"
    browser.wait(f"{trails}?.length === 20")
    assert len({*browser.run(f"return {trails}{look}")}) == 20
    marks = "[...document.querySelectorAll('.swatch')].map((each) => each.style.background)"
    browser.wait(f"new Set({marks}).size === 20")
