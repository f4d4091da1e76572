"""The panel of topics: rates, the inspector, publishing."""

from __future__ import annotations

import threading
import xmlrpc.client
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from browsing import Browser, Web

from pyros1.msgs.diagnostic_msgs.msg import DiagnosticStatus
from pyros1.msgs.geometry_msgs.msg import PoseArray, PoseStamped, TwistStamped
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.msgs.sensor_msgs.msg import LaserScan
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.web.links import panel_link

PATIENCE = 40.0
Make = Callable[..., Any]
LINE = "[...document.querySelectorAll('.line')].find((line) => line.dataset.key === {!r})"
TWIG = "[...document.querySelectorAll('.twig')].find((twig) => twig.querySelector('.copy').textContent === {!r})"


def choose(browser: Browser, name: str) -> None:
    browser.wait(LINE.format(name))
    browser.run(f"{LINE.format(name)}.querySelector('.cell').click()")


@pytest.fixture
def scanner(make_node: Make) -> Iterator[Any]:
    """A node that publishes /scan at about 50 Hz."""
    node = make_node("scanner")
    publisher = node.advertise("/scan", LaserScan)
    ended = threading.Event()

    def run() -> None:
        number = 0
        while not ended.wait(0.02):
            number += 1
            publisher.publish(LaserScan(scan_time=number, ranges=[float(x) for x in range(200)]))

    thread = threading.Thread(target=run)
    thread.start()
    yield publisher
    ended.set()
    thread.join()


def test_a_topic_without_subscribers_is_measured(browser: Browser, web: Web, scanner: Any) -> None:
    browser.open(web.page("topics"))
    browser.wait(f"{LINE.format('/scan')}?.textContent.includes('measure')")
    assert not scanner.num_connections
    browser.run(f"{LINE.format('/scan')}.querySelector('.measure').click()")
    browser.wait(f"/\\d+(\\.\\d+)? Hz/.test({LINE.format('/scan')}.textContent)")
    browser.run(f"{LINE.format('/scan')}.querySelector('.measure').click()")
    browser.wait(f"{LINE.format('/scan')}.textContent.includes('measure')")


def test_names_of_constants_are_those_of_the_type_that_comes(browser: Browser, web: Web, make_node: Make) -> None:
    node = make_node("robot")
    first = node.advertise("/thing", DiagnosticStatus, latch=True)
    first.publish(DiagnosticStatus(level=DiagnosticStatus.ERROR))
    browser.open(panel_link(web.link, "topics", {"selected": "/thing"}))
    word = f"{TWIG.format('level')}?.querySelector('.preview').textContent"
    browser.wait(f"{word} === 'ERROR'")
    first.unregister()
    node.advertise("/thing", Log, latch=True).publish(Log(level=Log.INFO))  # the same number
    browser.wait(f"{word} === 'INFO'")


def test_all_topics_without_subscribers_are_measured_at_once(
    browser: Browser, web: Web, scanner: Any, make_node: Make
) -> None:
    node = make_node("many")
    for number in range(60):
        node.advertise(f"/quiet{number}", Float64)
    browser.open(web.page("topics"))
    browser.type("input.search", "scan")
    browser.wait("document.querySelectorAll('.line').length === 1")
    browser.click(".tools button", "Measure all")
    browser.wait(f"/\\d+(\\.\\d+)? Hz/.test({LINE.format('/scan')}.textContent)")
    browser.click(".tools button", "Stop measuring (1)")
    browser.type("input.search", "")
    browser.click(".tools button", "Measure all")
    browser.wait_for_text("Stop measuring (50)")  # no more than that
    browser.click(".tools button", "Stop measuring (50)")
    browser.wait_for_text("Measure all")
    until(lambda: not scanner.num_connections)


def until(fits: Callable[[], object]) -> None:
    tick = threading.Event()
    for _ in range(200):
        if fits():
            return
        tick.wait(0.1)
    raise AssertionError("never so")


def test_types_are_whole_or_not_there(browser: Browser, web: Web, scanner: Any) -> None:
    browser.resize(1400, 900)
    browser.open(web.page("topics"))
    heads = "[...document.querySelectorAll('.table .sort')].map((each) => each.textContent).join()"
    browser.wait(f"{heads}.includes('type')")
    choose(browser, "/scan")
    browser.wait(f"!{heads}.includes('type')")
    browser.click(".shut")
    browser.wait(f"{heads}.includes('type')")


def test_messages_are_inspected(browser: Browser, web: Web, scanner: Any) -> None:
    browser.open(web.page("topics"))
    choose(browser, "/scan")
    browser.wait_for_text("scan_time")
    browser.wait("/rate\\d.* Hz/.test(document.querySelector('.figures').textContent)")
    value = f"Number({TWIG.format('scan_time')}.querySelector('.value').textContent)"
    first = browser.run(f"return {value}")
    browser.wait(f"{value} > {first}")
    browser.wait("document.querySelectorAll('.numbers .value').length === 64")
    browser.click(".pager button[title*=after]")
    browser.wait("document.querySelector('.numbers .value').textContent === '64'")
    browser.click("button", "Freeze")
    browser.wait("document.querySelector('.inspector .actions > button').textContent === 'Resume'")
    browser.click(".pager button[title*=after]")
    browser.wait("document.querySelector('.numbers .value').textContent === '128'")
    frozen = browser.run(f"return {value}")
    browser.wait("/age[\\d.]+ s/.test(document.querySelector('.figures').textContent)")
    assert browser.run(f"return {value}") == frozen
    browser.click(".tab", "Definition")
    browser.wait_for_text("float32 angle_increment")


def test_a_click_on_a_number_plots_it(browser: Browser, web: Web, scanner: Any) -> None:
    browser.open(web.page("topics"))
    choose(browser, "/scan")
    browser.wait(f"{TWIG.format('scan_time')}?.querySelector('button.value').textContent")
    browser.run(f"{TWIG.format('scan_time')}.querySelector('button.value').click()")
    browser.wait("document.querySelector('.chip .name')?.textContent === '/scan/scan_time'")
    browser.wait("Number(document.querySelector('.chip .value').textContent) > 0")


def test_publish_with_a_form_and_yaml(browser: Browser, web: Web, make_node: Make) -> None:
    heard: list[Any] = []
    make_node("base").subscribe("/cmd", TwistStamped, heard.append)
    browser.open(web.page("topics"))
    choose(browser, "/cmd")
    browser.click(".tab", "Publish")
    browser.type("input[aria-label='x (float64)']", "1.5")
    browser.type("textarea[aria-label='frame_id (string)']", "base")
    browser.click(".publisher button", "Publish")
    browser.wait_for_text("sent to 1 subscriber")
    assert (heard[0].twist.linear.x, heard[0].header.frame_id) == (1.5, "base")
    assert heard[0].header.stamp.secs > 0  # "now"
    browser.type("input[aria-label='x (float64)']", "fast")
    browser.wait_for_text("x (float64): not a number")
    browser.click(".publisher .actions button", "Publish")
    browser.wait("document.querySelectorAll('.publisher .outcome.wrong:not([hidden])').length === 1")
    browser.click(".publisher button", "Publish")
    browser.type("input[aria-label='x (float64)']", "2")
    browser.click(".editor .tab", "YAML")
    browser.wait("document.querySelector('.yaml')?.value.includes('x: 2')")
    browser.type(".yaml", "twist: {linear: {y: 3}}")
    browser.click(".publisher button", "Publish")
    browser.wait("document.querySelector('.publisher > .outcome').textContent.includes('sent')")
    browser.click(".editor .tab", "Form")
    browser.wait("document.querySelector(\"input[aria-label='y (float64)']\")?.value === '3'")
    browser.wait("document.querySelector('.publisher > .outcome').textContent.includes('sent')")
    browser.click(".editor .tab", "YAML")
    browser.wait("document.querySelector('.yaml')?.value.includes('y: 3')")
    browser.type(".yaml", "twist: 5")
    browser.wait("document.querySelector('.editor .outcome.wrong:not([hidden])')")


def test_orientations_begin_without_rotation(browser: Browser, web: Web, make_node: Make) -> None:
    make_node("base").subscribe("/goals", PoseArray, print)
    make_node("base2").subscribe("/goal", PoseStamped, print)
    browser.open(web.page("topics"))
    for topic in ("/goal", "/goals"):
        choose(browser, topic)
        browser.click(".tabbar .tab", "Publish")
        browser.wait(
            "document.querySelector('.form') && document.querySelector('.about h3').textContent === arguments[0]", topic
        )
        if topic == "/goals":
            browser.click(".form .add", "Add to poses")
        browser.wait("document.querySelector(\"input[aria-label='w (float64)']\")?.value === '1'")


def test_to_publish_as_its_command_opens_it(browser: Browser, web: Web, make_node: Make) -> None:
    make_node("motor").subscribe("/speed", "std_msgs/Float64", lambda message: None)
    browser.open(panel_link(web.link, "topics", {"publish": "/speed"}))
    browser.wait("document.querySelector('.publisher input')")
    browser.open(panel_link(web.link, "topics", {"publish": "/new"}))
    browser.wait("document.querySelector('.about input[aria-label=topic]')?.value === '/new'")


def test_publish_at_a_rate_until_the_page_goes(browser: Browser, web: Web, make_node: Make) -> None:
    heard: list[float] = []
    subscriber = make_node("ear").subscribe("/speed", Float64, lambda message: heard.append(message.data))
    browser.open(web.page("topics"))
    choose(browser, "/speed")
    browser.click(".tab", "Publish")
    browser.wait("document.querySelector('.form input')")
    browser.type(".publisher .actions input[type=number]", "100")
    browser.click(".publisher button", "Repeat")
    browser.wait("parseInt(document.querySelector('.publisher > .outcome').textContent) > 20")
    browser.type(".form input", "4")
    browser.wait("parseInt(document.querySelector('.publisher > .outcome').textContent) > 60")
    assert heard[0] == 0.0 and heard[-1] == 4.0
    browser.open("about:blank")
    wait_until_quiet(heard)
    assert subscriber.num_connections <= 1


def wait_until_quiet(heard: list[float]) -> None:
    tick = threading.Event()
    for _ in range(100):
        before = len(heard)
        tick.wait(0.3)
        if len(heard) == before:
            return
    raise AssertionError("it is still published")


def test_many_topics_are_a_tree_and_are_found(browser: Browser, web: Web, make_node: Make) -> None:
    node = make_node("many")
    for number in range(300):
        node.advertise(f"/robot{number % 3}/part{number % 10}/topic{number}", Float64)
    browser.open(web.page("topics"))
    browser.wait("[...document.querySelectorAll('.line.group')].some((line) => line.textContent.includes('/robot2'))")
    assert browser.run("return document.querySelectorAll('.line').length") < 20
    browser.run("[...document.querySelectorAll('.line.group')].find((line) => line.dataset.key === '/robot1/').click()")
    browser.wait(LINE.format("/robot1/part4/"))
    browser.click("button", "Tree")
    browser.wait("document.querySelectorAll('.line:not(.group)').length > 20")
    assert browser.run("return document.querySelectorAll('.line').length") < 100
    browser.type("input.search", "topic123")
    browser.wait("document.querySelectorAll('.line').length === 1")
    browser.type("input.search", "nothing like this")
    browser.wait_for_text("No names match")


def test_a_read_only_page_offers_no_changes(browser: Browser, start_web: Callable[..., Web], make_node: Make) -> None:
    make_node("ear").subscribe("/speed", Float64, print)
    web = start_web("--read-only", "--topics", "/s*")
    browser.open(web.page("topics"))
    browser.wait_for_text("read-only")
    choose(browser, "/speed")
    browser.wait_for_text("Definition")
    tabs = browser.run("return [...document.querySelectorAll('.tabbar .tab')].map((tab) => tab.textContent)")
    assert tabs == ["Message", "Definition"]
    assert "/rosout" not in browser.run("return document.querySelector('.table').innerText")
    assert browser.run(
        "return [...document.querySelectorAll('.tools button')].find((b) => b.textContent.includes('New')).hidden"
    )


def test_a_rate_that_is_not_known_says_so(browser: Browser, web: Web, make_node: Make, environ: dict[str, str]) -> None:
    browser.open(web.page("topics"))
    browser.wait(LINE.format("/rosout"))
    node = make_node("quiet")
    with xmlrpc.client.ServerProxy(environ["ROS_MASTER_URI"]) as master:  # it says that it is there, and never connects
        master.registerSubscriber("/ghost", "/ghost", "std_msgs/Empty", node.uri)
        master.registerPublisher("/ghost", "/ghost", "std_msgs/Empty", node.uri)
    shown = f"{LINE.format('/ghost')}?.querySelectorAll('.cell')[4].textContent"
    browser.wait(f"{shown} === '…'")
    browser.wait(f"{shown} === '?'")
