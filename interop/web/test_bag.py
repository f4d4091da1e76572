"""Bags on a page: open, look, play, record.

Feature: bags on the page: opened, inspected, plotted, played and recorded -- a 1.5 GB bag opens in 0.2 s
"""

from __future__ import annotations

import io
import math
import resource
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browsing import PATIENCE, Browser, Web
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys
from vitals import limited

import pyros1.bag
from pyros1.ground.timing import Time
from pyros1.msgs import load_message

BAG = "document.querySelector('.bag')?.bag"
START = 1_700_000_000
SHOWN = """[...document.querySelectorAll('.topic-message[data-topic="' + arguments[0] + '"] .twig .value')].map(
    (each) => each.textContent).join(' ')"""


@pytest.fixture
def bags(tmp_path: Path) -> Path:
    """A folder with a bag of 20 s: ten values a second that are a sine with a spike, and an event every 5 s."""
    folder = tmp_path / "bags"
    (folder / "inner").mkdir(parents=True)
    number, text = load_message("std_msgs/Float64"), load_message("std_msgs/String")
    with pyros1.bag.open(folder / "run.bag", "w", compression="lz4", chunk_threshold=4_000) as bag:
        for index in range(201):
            stamp = Time(START + index // 10, index % 10 * 100_000_000)
            bag.write("/value", number(100.0 if index == 123 else math.sin(index / 10)), stamp)
            if index % 50 == 0:
                bag.write("/event", text(f"event {index}"), stamp)
    return folder


@pytest.fixture
def page(browser: Browser, start_web: Callable[..., Web], bags: Path) -> Browser:
    """The bag, chosen from the list of files."""
    web = start_web("--bags", str(bags))
    browser.open(web.page("bag"))
    browser.click(".files .entry.file", "run.bag")
    browser.wait("document.querySelectorAll('.timeline .row').length === 2")
    return browser


def test_a_bag_is_chosen_and_described(page: Browser) -> None:
    page.wait_for_text("206 messages")
    page.wait_for_text("2 topics")
    page.wait_for_text("lz4")
    page.wait(f"{BAG}.timeline.data?.rows.get('/event')?.filter((count) => count > 0).length === 5")
    page.wait(f"{BAG}.timeline.data.rows.get('/value').reduce((sum, count) => sum + count, 0) === 201")


def test_the_messages_follow_the_cursor(page: Browser) -> None:
    page.click(".timeline .name", "/event")
    page.wait(f"{SHOWN} === 'event 0'", "/event")
    lane = page.driver.find_element("css selector", ".timeline .row .lane")
    ActionChains(page.driver).move_to_element(lane).click().perform()  # its middle
    page.wait(f"Math.abs({BAG}.time - 10) < 0.2")
    page.wait(f"['event 50', 'event 100'].includes({SHOWN})", "/event")
    keys = ActionChains(page.driver)
    keys.send_keys(Keys.END).perform()
    page.wait(f"{SHOWN} === 'event 200'", "/event")
    keys.send_keys(Keys.ARROW_LEFT).perform()
    page.wait(f"{BAG}.time === 15 && {SHOWN} === 'event 150'", "/event")
    keys.send_keys(Keys.ARROW_RIGHT).perform()
    page.wait(f"{BAG}.time === 20", "/event")


def test_a_number_that_is_clicked_is_plotted_with_its_spike(page: Browser) -> None:
    page.click(".timeline .name", "/value")
    page.click(".topic-message .value.num")
    page.wait(f"{BAG}.chart.curves[0]?.whole")
    curve = f"[...{BAG}.chart.curves[0].lines.values()][0]"
    times, values = page.run(
        f"const points = {curve}; return [points.times, points.values].map((a) => [...a.subarray(0, points.end)])"
    )
    assert max(values) == 100.0 and times[values.index(100.0)] == pytest.approx(12.3)
    assert values[:123] == pytest.approx([math.sin(index / 10) for index in range(123)])
    page.run(f"{BAG}.timeline.setView(12, 13)")
    page.wait(f"{BAG}.chart.curves[0].whole && {curve}.end === 11 && {BAG}.timeline.data.begin === 12")
    page.run(f"{BAG}.seek(12.35)")
    page.wait("document.querySelector('.chart .chip .value').textContent === '100'")
    page.click(".chart .chip button")
    page.wait("document.querySelector('.chart').hidden")


def test_zooming_and_all(page: Browser) -> None:
    page.driver.find_element("css selector", ".timeline").send_keys("+")
    page.wait(f"{BAG}.timeline.view[1] - {BAG}.timeline.view[0] < 15")
    page.click(".zooms button", "All")
    page.wait(f"{BAG}.timeline.view[0] < 0 && {BAG}.timeline.view[1] > 20")


def test_to_look_publishes_nothing(page: Browser, make_node: Callable[..., Any]) -> None:
    page.click(".player .play")
    page.wait(f"{BAG}.time > 0.5")
    node = make_node("observer")
    assert "/value" not in [topic for topic, _ in node.master.get_published_topics()]
    page.click(".player .play")
    page.wait(f"!{BAG}.player.playing")


def test_to_publish_reaches_the_robot_until_one_leaves(page: Browser, make_node: Callable[..., Any]) -> None:
    got: list[float] = []
    come = threading.Condition()

    def take(message: Any) -> None:
        with come:
            got.append(message.data)
            come.notify_all()

    node = make_node("listener")
    node.subscribe("/value", "std_msgs/Float64", take)
    page.run(f"{BAG}.seek(12)")
    page.run(
        "const mode = document.querySelector('.player .mode'); mode.value = 'publish';"
        "mode.dispatchEvent(new Event('change'));"
    )
    page.click(".player .play")
    with come:
        assert come.wait_for(lambda: 100.0 in got, PATIENCE)
    assert got[0] == pytest.approx(math.sin(12.0), abs=0.2)
    page.wait(f"{BAG}.time > 12.3")
    page.driver.get("about:blank")

    def ended() -> bool:
        return "/value" not in [topic for topic, _ in node.master.get_published_topics()]

    wait_until(ended)


def wait_until(fits: Callable[[], bool]) -> None:
    clock = threading.Event()
    for _ in range(int(PATIENCE / 0.1)):
        if fits():
            return
        clock.wait(0.1)
    raise AssertionError("never true")


def choose(page: Browser, selector: str, value: str) -> None:
    script = "const field = document.querySelector(arguments[0]); field.value = arguments[1];"
    page.run(script + "field.dispatchEvent(new Event('change'));", selector, value)


def publish(page: Browser) -> None:
    """Choose to publish, and play."""
    choose(page, ".player .mode", "publish")
    page.click(".player .play")


def nothing_is_published(node: Any) -> bool:
    return not {"/value", "/event"} & {topic for topic, _ in node.master.get_published_topics()}


def test_playing_ends_at_the_end_of_the_bag_and_begins_again(page: Browser, make_node: Callable[..., Any]) -> None:
    node = make_node("listener")
    got: list[float] = []
    node.subscribe("/value", "std_msgs/Float64", lambda message: got.append(message.data))
    page.run(f"{BAG}.seek(19.5)")
    publish(page)
    page.wait(f"!{BAG}.player.playing && {BAG}.player.state === 'ended' && {BAG}.time === 20")
    page.wait("document.querySelector('.player .play').textContent === '▶'")
    page.click(".player .play")
    page.wait(f"{BAG}.player.playing && {BAG}.time > 0.3 && {BAG}.time < 5")
    wait_until(lambda: got.count(0.0) == 1)  # the first message of the bag
    page.click(".player button", "Loop")
    page.run(f"{BAG}.seek(19.5)")
    wait_until(lambda: got.count(0.0) == 2)
    assert page.run(f"return {BAG}.player.playing")
    choose(page, ".player .mode", "look")
    wait_until(lambda: nothing_is_published(node))


def test_a_bag_that_breaks_while_it_is_played_says_why(
    page: Browser, bags: Path, make_node: Callable[..., Any]
) -> None:
    node = make_node("observer")
    file = bags / "run.bag"
    size = file.stat().st_size
    with open(file, "r+b") as bag:  # the index was read; the messages in the middle are gone now
        bag.seek(size // 3)
        bag.write(b"\xff" * (size // 3))
    choose(page, ".player select", "10")
    publish(page)
    page.wait(f"!{BAG}.player.playing && {BAG}.player.state === 'failed'")
    notes = "[...document.querySelectorAll('.panel .note')]"
    page.wait(f"{notes}.some((each) => !each.hidden && each.textContent.length > 10)")
    page.driver.get("about:blank")
    wait_until(lambda: nothing_is_published(node))


def test_recording_with_a_click(page: Browser, make_node: Callable[..., Any], bags: Path) -> None:
    publisher = make_node("talker").advertise("/counter", "std_msgs/Int32")
    page.click("button.record")
    page.click("dialog .files .entry", "inner")
    page.wait("document.querySelector('dialog .place-name').textContent.includes('inner')")
    page.type("dialog input[aria-label=name]", "day")
    page.click("dialog button.primary")
    page.wait_for_text("Recording")
    assert publisher.wait_for_subscribers(timeout=PATIENCE)
    for number in range(30):
        publisher.publish(number)
    page.wait("/[1-9]\\d* messages/.test(document.querySelector('.recording .line').textContent)")
    page.click(".recording button", "Stop")
    page.wait_for_text("Recorded")
    (path,) = (bags / "inner").glob("day_*.bag")
    with pyros1.bag.open(path) as bag:
        assert [each.message.data for each in bag.messages("/counter")] == list(range(30))
    page.click(".recording button", "Open")
    page.wait("[...document.querySelectorAll('.timeline .topic')].some((each) => each.textContent === '/counter')")


def test_a_recording_that_had_to_end_is_told_at_the_next_visit(
    browser: Browser, start_web: Callable[..., Web], bags: Path, make_node: Callable[..., Any]
) -> None:
    web = start_web("--bags", str(bags))
    publisher = make_node("talker").advertise("/text", "std_msgs/String", queue_size=0)
    browser.open(web.page("bag"))
    browser.wait("window.robot?.state === 'connected'")
    browser.run("robot.call('bags.record', {folder: arguments[0], topics: ['/text']})", str(bags))
    assert publisher.wait_for_subscribers(timeout=PATIENCE)
    browser.driver.get("about:blank")
    with limited(web.process.pid, resource.RLIMIT_FSIZE, 200_000):
        while publisher.num_connections:  # it ends by itself
            publisher.publish("x" * 20_000)
        browser.open(web.page("bag"))
        browser.wait_for_text("cannot write the bag")
    browser.click(".recording button", "✕")
    browser.wait("document.querySelector('.recording').hidden")


def test_who_may_only_look_cannot_publish_or_record(
    browser: Browser, start_web: Callable[..., Web], bags: Path
) -> None:
    web = start_web("--bags", str(bags), "--read-only")
    browser.open(web.page("bag"))
    browser.click(".files .entry.file", "run.bag")
    browser.wait("document.querySelectorAll('.timeline .row').length === 2")
    browser.wait("document.querySelector('button.record').disabled")
    browser.wait(
        "[...document.querySelectorAll('.mode option')].map((each) => each.disabled).join() === 'false,true,true'"
    )


def test_files_that_cannot_be_opened_say_why(browser: Browser, start_web: Callable[..., Web], bags: Path) -> None:
    data = (bags / "run.bag").read_bytes()
    (bags / "bad.bag").write_bytes(b"nothing")
    (bags / "cut.bag").write_bytes(data[: len(data) * 2 // 3])
    web = start_web("--bags", str(bags))
    browser.open(web.page("bag"))
    browser.click(".files .entry.file", "bad.bag")
    browser.wait_for_text("not a bag")
    browser.click(".other button", "Choose another bag")
    browser.click(".files .entry.file", "cut.bag")
    browser.wait("document.querySelectorAll('.timeline .row').length === 2")
    browser.wait_for_text("pyros1 bag reindex")


def test_a_bag_of_the_command_line(browser: Browser, start_web: Callable[..., Web], bags: Path, tmp_path: Path) -> None:
    secret = tmp_path / "secret.bag"
    secret.write_bytes((bags / "run.bag").read_bytes())
    web = start_web("--bags", str(bags / "inner"), "bag", str(bags / "run.bag"))
    browser.open(web.link)
    browser.wait_for_text("206 messages")
    browser.run(f"{BAG}.open(arguments[0])", str(secret))
    browser.wait_for_text("outside the folders")


def test_pictures_along_the_row(browser: Browser, start_web: Callable[..., Web], bags: Path) -> None:
    pil = pytest.importorskip("PIL.Image")
    compressed = load_message("sensor_msgs/CompressedImage")
    with pyros1.bag.open(bags / "camera.bag", "w") as bag:
        for index in range(50):
            pixels = np.full((120, 160, 3), index * 5, np.uint8)
            file = io.BytesIO()
            pil.fromarray(pixels).save(file, "JPEG")
            bag.write("/camera/compressed", compressed(format="jpeg", data=file.getvalue()), Time(START + index, 0))
    web = start_web("--bags", str(bags))
    browser.open(web.page("bag"))
    browser.click(".files .entry.file", "camera.bag")
    browser.wait("document.querySelectorAll('.timeline .pictures img').length > 3")
    browser.wait("[...document.querySelectorAll('.timeline .pictures img')].every((each) => each.naturalHeight === 92)")
    browser.click(".timeline .name", "/camera/compressed")
    browser.wait("document.querySelector('.picture')?.naturalWidth === 160")
    browser.wait_for_text("160 \u00d7 120")


def test_it_is_readable_on_a_phone(page: Browser) -> None:
    page.run(f"{BAG}.chart.add('/value/data')")
    page.wait("document.querySelector('.chart .u-over')")
    page.resize(390, 800)
    page.wait("document.documentElement.scrollWidth <= 390")
    page.wait(f"{BAG}.timeline.width > 250")
    left = "document.querySelector('.{}').getBoundingClientRect().left"  # times are below each other
    page.wait(f"Math.abs({left.format('chart .u-over')} - {left.format('timeline .row .lane')}) < 2")
    page.click(".timeline .name", "/event")
    page.wait(f"{SHOWN} === 'event 0'", "/event")


def test_a_topic_that_begins_later_offers_its_first_message(
    browser: Browser, start_web: Callable[..., Web], tmp_path: Path
) -> None:
    number = load_message("std_msgs/Float64")
    with pyros1.bag.open(tmp_path / "late.bag", "w") as bag:
        for index in range(50):
            bag.write("/early", number(float(index)), Time(START + index, 0))
        for index in range(20, 50):
            bag.write("/late", number(float(index)), Time(START + index, 0))
    web = start_web("--bags", str(tmp_path))
    browser.resize(1400, 900)
    browser.open(web.page("bag"))
    browser.click(".files .entry.file", "late.bag")
    browser.click(".timeline .name", "/late")
    browser.wait_for_text("No message yet at this time.")
    browser.click(".topic-message .first")
    browser.wait(f"{SHOWN} === '20'", "/late")
    browser.resize(390, 844)
    browser.run(f"{BAG}.chart.add('/late/data')")
    room = "844 - document.querySelector('.inspected').getBoundingClientRect().top"
    browser.wait(f"document.querySelector('.chart canvas') && {room} > 120")
    wide = "document.querySelector('.topic-message header .steps').offsetHeight"
    assert browser.run(f"return {wide}") < 40  # the buttons are in one line


def test_a_bag_without_messages_takes_no_keys(browser: Browser, start_web: Callable[..., Web], tmp_path: Path) -> None:
    pyros1.bag.open(tmp_path / "nothing.bag", "w").close()
    browser.open(start_web("--bags", str(tmp_path)).page("bag"))
    browser.click(".files .entry.file", "nothing.bag")
    browser.wait_for_text("This bag is empty")
    for key in ("0", "-", "Home", "ArrowRight"):  # an error would be a complaint in the browser's console
        browser.run(f"{BAG}.place.body.dispatchEvent(new KeyboardEvent('keydown', {{key: arguments[0]}}))", key)


def test_an_empty_bag_and_a_record_dialog_say_what_to_do(
    browser: Browser, start_web: Callable[..., Web], tmp_path: Path
) -> None:
    (tmp_path / "inner").mkdir()
    web = start_web("--bags", str(tmp_path))
    browser.open(web.page("bag"))
    browser.wait_for_text("pyros1 web --bags FOLDER")
    browser.click("button.record")
    browser.wait_for_text("compression")
    browser.wait("!document.querySelector('.record-dialog .primary').disabled")
    # the server may write everywhere here, so the page is told otherwise
    browser.run(
        "const call = window.robot.call.bind(window.robot);"
        "window.robot.call = async (...words) => ({...await call(...words), writable: false});"
    )
    browser.click(".record-dialog .entry.folder", "inner")
    browser.wait_for_text("this server may not write to this folder")
    assert browser.run("return document.querySelector('.record-dialog .primary').disabled")
