"""The page: coming in, going away, coming back.

Feature: the page: token, rejected host names and origins, custom layouts, a menu on phones, reconnecting to a
    restarted server
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from browsing import Browser, Web
from harness import free_port

from pyros1.ground.timing import Time
from pyros1.master.server import Master
from pyros1.msgs.rosgraph_msgs.msg import Log


def test_every_panel_opens_without_complaint(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    make_node("talker").log.warn("hello")
    browser.open(web.page(""))
    names = browser.wait("[...document.querySelectorAll('.tab')].map((tab) => tab.textContent)")
    assert {"Console", "Plot"} <= {*names}
    for size in ((1280, 800), (390, 800)):
        browser.resize(*size)
        for name in names:
            browser.click(".tab", name)
            browser.wait("document.querySelector('.panel .body').childElementCount > 0")
            wide = browser.run("return document.documentElement.scrollWidth - innerWidth")
            assert wide <= 0, f"{name} is wider than the page, by {wide} pixels"


def test_the_page_says_that_it_loads(browser: Browser, web: Web) -> None:
    driver = browser.driver
    driver.execute_cdp_cmd("Network.enable", {})
    driver.execute_cdp_cmd("Network.setBlockedURLs", {"urls": ["*/lib/*"]})
    try:
        browser.open(web.page(""))
        browser.wait_for_text("Loading …")
    finally:
        driver.execute_cdp_cmd("Network.setBlockedURLs", {"urls": []})
        driver.execute_cdp_cmd("Network.disable", {})
    browser.open(web.page(""))
    browser.wait("document.querySelector('.panel') && !document.querySelector('.loading')")
    browser.complaints()  # of what did not come


def test_the_consoles_buttons_are_in_one_line(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    browser.resize(1280, 800)
    browser.open(web.page("console"))
    log_until_shown(browser, make_node("talker").log)
    busy = "for (const each of document.querySelectorAll('.levels button')) each.textContent = 'error 999 k'"
    tools = "[...document.querySelectorAll('.tools > :not([hidden])')]"
    heights = browser.run(f"{busy}; return {tools}.map((each) => each.offsetTop + each.offsetHeight / 2)")
    assert len(heights) == 10
    assert max(heights) - min(heights) < 10, heights
    fields = "[...document.querySelectorAll('.filter')].map((each) => [each.ariaLabel, each.clientWidth])"
    widths = dict(browser.run(f"return {fields}"))
    assert widths["highlight"] > 68 and min(widths.values()) > 56, "the words in the fields are read whole"


def test_without_the_token_the_page_says_what_to_do(browser: Browser, web: Web) -> None:
    browser.open(web.link.replace("token=", "token=x"))
    browser.wait_for_text(
        "pyros1 web creates a new token each time it starts. "
        "Use the link that the server printed, or run `pyros1 web graph`"
    )
    browser.driver.get("about:blank")  # the page would try again
    assert any("401" in text or "WebSocket" in text for text in browser.complaints())


def test_a_master_that_comes_later_is_found(
    browser: Browser, environ: dict[str, str], start_web: Callable[..., Web], make_node: Callable[..., Any]
) -> None:
    port = free_port()
    environ["ROS_MASTER_URI"] = f"http://localhost:{port}/"
    web = start_web()
    browser.open(web.page("plot"))
    browser.type(".tools form input", "/topic1/data")
    browser.click(".tools form button", "Add")
    browser.wait_for_text("start one with: pyros1 core")
    browser.wait("document.querySelector('.state.lost').textContent === 'no master'")
    browser.click(".tab", "Topics")
    browser.wait_for_text("no ROS master at")
    shown = "[...document.querySelectorAll('.panel button')].filter((each) => each.checkVisibility())"
    assert browser.run(f"return {shown}.every((each) => each.textContent || each.ariaLabel)")
    browser.click(".tab", "Plot")
    master = Master(port=port, bind_host="127.0.0.1")
    master.start()
    try:
        make_node("talker").advertise("topic1", "std_msgs/Float64", latch=True).publish(7.5)
        browser.wait("document.querySelector('.chip .value').textContent === '7.5'")
        browser.wait("document.querySelector('.state.connected .master')?.textContent.includes('localhost')")
    finally:
        master.stop()


def test_nothing_from_the_robot_becomes_markup(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    evil = "<img src=x onerror=\"document.title='owned'\"><script>document.title='owned'</script>"
    node = make_node("talker")
    node.log.error("%s", evil)
    browser.open(web.page("console"))
    browser.wait_for_text(evil)
    browser.click(".entry", "img src")
    browser.wait("document.querySelector('.detail pre').textContent.includes('onerror')")
    assert browser.run("return document.title") == "Console \u2013 pyros1"
    assert browser.run("return document.querySelectorAll('.panel img, .panel script').length") == 0


def test_the_log_survives_a_reload(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    log = make_node("talker").log
    browser.open(web.page("console"))
    log_until_shown(browser, log)
    browser.click("button", "Clear")
    for number in range(300):
        log.warn("line %d", number)
    browser.wait("document.querySelector('.levels .warn').textContent === 'warn 300'")
    browser.driver.refresh()
    browser.wait("document.querySelector('.levels .warn')?.textContent === 'warn 300'")
    browser.wait_for_text("line 299")
    browser.type("input[placeholder=text]", "/line 29[0-4]$/")
    browser.wait("document.querySelectorAll('.entry').length === 5")
    browser.click(".levels .warn")
    browser.wait_for_text("No messages match the filters")


def test_the_page_goes_on_when_the_server_comes_back(
    browser: Browser, start_web: Callable[..., Web], make_node: Callable[..., Any]
) -> None:
    port = free_port()
    web = start_web("--port", str(port), "--token", "same")
    browser.open(web.page("console"))
    log = make_node("talker").log
    log.warn("before")
    browser.wait_for_text("before")
    web.process.terminate()
    web.process.wait(30)
    browser.wait_for_text("the server does not answer")
    start_web("--port", str(port), "--token", "same")
    browser.wait("document.querySelector('.banner').hidden")
    log_until_shown(browser, log)
    browser.complaints()  # of the time in between


def test_the_log_of_a_new_run_is_shown_beside_the_old(
    browser: Browser, start_web: Callable[..., Web], make_node: Callable[..., Any]
) -> None:
    port = free_port()
    web = start_web("--port", str(port), "--token", "same")
    browser.open(web.page("console"))
    log = make_node("talker").log
    log_until_shown(browser, log)
    for number in range(3000):  # more than the new run will have
        log.debug("old %d", number)
        log.warn("old %d", number)
    browser.wait_for_text("old 2999")
    web.process.terminate()
    web.process.wait(30)
    browser.wait_for_text("the server does not answer")
    start_web("--port", str(port), "--token", "same")
    browser.wait("document.querySelector('.banner').hidden")
    browser.type("input[placeholder=text]", "/new run|old 2999/")
    until = time.monotonic() + 20
    while not browser.run("return document.body.innerText.includes('new run')"):
        assert time.monotonic() < until
        log.warn("new run")
        time.sleep(0.1)
    browser.wait_for_text("old 2999")
    browser.complaints()  # of the time in between


def test_a_slow_click_on_a_busy_log_and_the_keyboard(browser: Browser, web: Web, make_node: Callable[..., Any]) -> None:
    log = make_node("talker").log
    browser.open(web.page("console"))
    log_until_shown(browser, log)
    log.error("the one")
    with browser.pressed(".entry.error", "the one"):
        for number in range(100):  # the list moves on, and the row with it
            log.warn("line %d", number)
        browser.wait("document.querySelector('.levels .warn').textContent === 'warn 100'")
        browser.wait_for_text("line 99")
    shown = "document.querySelector('.detail:not([hidden]) pre')?.textContent"
    browser.wait(f"{shown} === 'the one'")
    for key, text in (("Escape", None), ("ArrowUp", "line 99"), ("ArrowUp", "line 98"), ("ArrowDown", "line 99")):
        browser.run(
            "document.querySelector('.log').dispatchEvent(new KeyboardEvent('keydown', {key: arguments[0]}))", key
        )
        browser.wait(f"{shown} == arguments[0]", text)
    browser.wait("document.querySelector('.entry[aria-selected=true]')?.textContent.includes('line 99')")


def test_a_saved_log_keeps_its_nanoseconds_and_marks(
    browser: Browser, web: Web, make_node: Callable[..., Any], tmp_path: Path
) -> None:
    publisher = make_node("talker", rosout=False).advertise("/rosout", Log)
    browser.open(web.page("console"))
    assert publisher.wait_for_subscribers(timeout=20)
    texts = ['say "\\"; then', "C:\\dir\\", '";"']
    stamps = ((1_700_000_000, 123_456_789), (1_700_000_000, 999_999_999), (1_700_000_001, 1))
    for text, stamp in zip(texts, stamps, strict=True):
        message = Log(name="/talker", level=2, msg=text)
        message.header.stamp = Time(*stamp)
        publisher.publish(message)
    browser.wait("document.querySelectorAll('.entry').length === 3")
    text = browser.saved("button", "Save").decode()
    saved = [line.split(";")[-3] for line in text.splitlines()[1:]]
    assert saved == ['"1700000000.123456789"', '"1700000000.999999999"', '"1700000001.000000001"']
    file = tmp_path / "console.csv"
    file.write_text(text.replace("dir\\ ", "dir\\"))  # rqt_console writes no space there
    browser.driver.find_element("css selector", "input[type=file]").send_keys(str(file))
    browser.wait_for_text("3 messages of console.csv")
    assert browser.run("return [...document.querySelectorAll('.entry .text')].map((each) => each.textContent)") == texts


SAVED = r"""message;severity;node;stamp;topics;location
"Odometry lost, \"wheel\" blocked";"8";"/base";"1700000000.000000001";"/rosout,/odom";"base.py:drive:12"
"a text
of two lines";"2";"/planner";"1700000001.500000000";"/rosout";"planner.cpp:Planner::plan:90"
"battery at 30 %";"4";"/battery";"1700000002.000000000";"";"::0"
"battery at 9 %";"4";"/battery";"1700000003.000000000";"";"::0"
"""


def test_a_file_of_rqt_console(browser: Browser, web: Web, make_node: Callable[..., Any], tmp_path: Path) -> None:
    """It is filtered, marked and counted as the robot's messages are, which come back."""
    file = tmp_path / "console.csv"
    file.write_text(SAVED)
    log = make_node("talker").log
    browser.open(web.page("console"))
    log_until_shown(browser, log)
    browser.driver.find_element("css selector", "input[type=file]").send_keys(str(file))
    rows = "[...document.querySelectorAll('.entry .text')].map((each) => each.textContent).join()"
    whole = 'Odometry lost, "wheel" blocked,a text,battery at 30 %,battery at 9 %'
    browser.wait(f"{rows} === arguments[0]", whole)
    browser.wait_for_text("4 messages of console.csv")
    assert browser.run("return document.querySelector('.levels .warn').textContent") == "warn 2"
    browser.type("[aria-label=text]", r"/battery at \d %/")
    browser.wait(f"{rows} === 'battery at 9 %'")
    browser.type("[aria-label=text]", "/battery(/")
    browser.wait_for_text("Invalid regular expression")
    browser.type("[aria-label=text]", "")
    browser.type("[aria-label=node]", "/odom")  # a topic
    browser.wait(f"{rows} === arguments[0]", 'Odometry lost, "wheel" blocked')
    browser.type("[aria-label=node]", "")
    browser.type("[aria-label=highlight]", "/^(battery|a text)/")
    marked = "[...document.querySelectorAll('.entry.marked .text')].map((each) => each.textContent).join()"
    browser.wait(f"{marked} === 'a text,battery at 30 %,battery at 9 %'")
    for words, texts in {
        "/base": ['Odometry lost, "wheel" blocked'],  # a node
        "/odom": ['Odometry lost, "wheel" blocked'],  # a topic
        "warn": ["battery at 30 %", "battery at 9 %"],
        "wheel": ['Odometry lost, "wheel" blocked'],
    }.items():
        browser.type("[aria-label=highlight]", words)
        browser.wait(f"{marked} === arguments[0]", ",".join(texts))
    browser.type("[aria-label=exclude]", "/(9|30) %/")
    browser.wait(f"{rows} === arguments[0]", 'Odometry lost, "wheel" blocked,a text')
    browser.type("[aria-label=exclude]", "/(9/")
    browser.wait_for_text("Invalid regular expression")
    browser.wait(f"{rows} === arguments[0]", whole)
    browser.type("[aria-label=exclude]", "")
    browser.click(".levels .warn")
    browser.wait(f"{rows} === arguments[0]", 'Odometry lost, "wheel" blocked,a text')
    browser.click(".levels .warn")
    assert browser.saved("button", "Save").decode() == SAVED
    browser.click("button", "Resume")
    browser.wait_for_text("are you there?")
    assert not browser.run("return document.body.innerText.includes('battery')")


def log_until_shown(browser: Browser, log: Any) -> None:
    """Log until the server listens and the page shows it."""
    until = time.monotonic() + 20
    while not browser.run("return document.body.innerText.includes('are you there?')"):
        assert time.monotonic() < until
        log.info("are you there?")


def test_levels_are_those_of_the_chosen_messages_node(
    browser: Browser, web: Web, make_node: Callable[..., Any]
) -> None:
    log = make_node("talker").log
    browser.resize(390, 844)
    browser.open(web.page("console"))
    log_until_shown(browser, log)
    browser.click(".tools button", "Levels")
    browser.wait_for_text("Choose a message first")
    browser.run("document.querySelector('.log').dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowUp'}))")
    place = browser.wait(
        "[...document.querySelectorAll('.detail dt')].find((each) => each.textContent === 'place')"
        "?.nextSibling.getBoundingClientRect().toJSON()"
    )
    assert 0 < place["bottom"] <= 844
    browser.click(".tools button", "Levels")
    browser.wait("document.querySelector('.loggers[open] select')?.value")
    assert browser.run("return document.querySelector('.about h3').textContent") == "/talker"
