"""The panels of services, parameters and nodes."""

from __future__ import annotations

import base64
import json
import threading
from collections.abc import Callable
from typing import Any

from browsing import Browser, Web

from pyros1.actions import SimpleServer
from pyros1.ground.errors import Error
from pyros1.msgs.actionlib_tutorials.msg import FibonacciAction, FibonacciFeedback, FibonacciResult
from pyros1.msgs.std_srvs.srv import SetBool, SetBoolResponse
from pyros1.reconfigure import Parameters, Server
from pyros1.web.links import panel_link

PATIENCE = 40.0
Make = Callable[..., Any]
LINE = "[...document.querySelectorAll('.line')].find((line) => line.dataset.key === {!r})"
RIGHT = "document.querySelector(arguments[0]).getBoundingClientRect().right"


def choose(browser: Browser, name: str) -> None:
    browser.wait(LINE.format(name))
    browser.run(f"{LINE.format(name)}.querySelector('.cell').click()")


def test_call_a_service(browser: Browser, web: Web, make_node: Make) -> None:
    def switch(request: Any) -> Any:
        if not request.data:
            raise Error("it is stuck")
        return SetBoolResponse(success=True, message="it is on")

    make_node("lamp").advertise_service("/switch", SetBool, switch)
    browser.open(web.page("services"))
    browser.wait(f"{LINE.format('/switch')}?.textContent.includes('std_srvs/SetBool')")
    assert not browser.run(f"return {LINE.format('/lamp/get_loggers')}")
    choose(browser, "/switch")
    browser.click(".caller button", "Call")
    browser.wait("document.querySelector('.caller > .outcome.wrong')?.textContent.includes('it is stuck')")
    browser.click(".form input[type=checkbox]")
    browser.click(".caller button", "Call")
    browser.wait_for_text("it is on")
    browser.wait("/answered in [\\d.]+ m?s/.test(document.querySelector('.caller').textContent)")
    browser.click(".tools button", "Loggers")
    browser.wait(LINE.format("/lamp/get_loggers"))


def test_a_text_is_edited_as_it_is(browser: Browser, web: Web, make_node: Make) -> None:
    params = make_node("setter").params
    params["/label"] = "12: 'left'"
    browser.open(web.page("params"))
    choose(browser, "/label")
    browser.wait("document.querySelector('.about .yaml').value === arguments[0]", "12: 'left'")
    browser.type(".about .yaml", '"yes": #1\\')
    browser.click(".about button", "Save")
    browser.wait_for_text("saved")
    assert params["/label"] == '"yes": #1\\'
    browser.click(".about button", "as YAML")
    browser.wait("document.querySelector('.about .yaml').ariaLabel === 'value as YAML'")
    browser.type(".about .yaml", "[1, 2]")
    browser.click(".about button", "Save")
    browser.wait("[...document.querySelectorAll('.line')].some((line) => line.textContent.includes('[1, 2]'))")
    assert params["/label"] == [1, 2]


def test_parameters_are_edited_and_changes_are_seen(browser: Browser, web: Web, make_node: Make) -> None:
    params = make_node("setter").params
    params["/arm/speed"] = 1.5
    browser.open(web.page("params"))
    browser.wait(f"{LINE.format('/arm/speed')}?.textContent.includes('1.5')")
    choose(browser, "/arm/speed")
    browser.wait("document.querySelector('.about .yaml').value === '1.5'")
    params["/arm/speed"] = 2.5
    browser.wait("document.querySelector('.about .yaml').value === '2.5'")
    browser.type(".about .yaml", "[1, two]")
    browser.click(".about button", "Save")
    browser.wait_for_text("saved")
    assert params["/arm/speed"] == [1, "two"]
    browser.type(".about .yaml", "[1, ")
    browser.click(".about button", "Save")
    browser.wait("document.querySelector('.about > .outcome.wrong:not([hidden])')")
    browser.click(".about .asking button", "Delete")
    browser.click(".about .asking button", "No")
    browser.click(".about .asking button", "Delete")
    browser.click(".about .asking button", "Yes")
    browser.wait(f"!{LINE.format('/arm/speed')}")
    assert "/arm/speed" not in params
    browser.click("button", "New")
    browser.type(".about input", "arm/name")
    browser.type(".about .yaml", "left")
    browser.click(".about button", "Set")
    browser.wait(f"{LINE.format('/arm/name')}?.textContent.includes('left')")
    assert params["/arm/name"] == "left"


def test_dynamic_reconfigure_is_live_both_ways(browser: Browser, web: Web, make_node: Make) -> None:
    parameters = Parameters()
    parameters.add("rate", 10.0, "of the output", minimum=0.0, maximum=100.0)
    parameters.add("on", False)
    parameters.add("mode", 0, choices={"Slow": 0, "Fast": 1})
    parameters.add("frame", "map")
    parameters.group("limits", type="collapse", state=False).add("most", 1)
    parameters.group("expert", type="hide", state=False).add("secret", 1)
    current: dict[str, Any] = {}

    def changed(config: Any, level: int) -> Any:
        current.update(config)
        return config

    server = Server(make_node("motor"), parameters, changed)
    browser.open(web.page("params"))
    browser.wait("document.querySelector(\".tools option[value='/motor']\")")
    browser.type(".tools select[aria-label='dynamic_reconfigure']", "/motor")
    browser.wait("document.querySelector('.configure .num')?.value === '10'")
    states = "[...document.querySelectorAll('details.group')].map(({open, hidden}) => [open, hidden])"
    assert browser.run(f"return {states}") == [[False, False], [True, True]]
    limits = server.config["groups"]["groups"]["limits"]
    browser.click("details.group summary", "limits")  # the node keeps it
    wait_for(lambda: limits["state"])
    browser.click("details.group summary", "limits")
    wait_for(lambda: not limits["state"])
    browser.type(".configure input[type=range]", "50")
    browser.wait("document.querySelector('.configure .num').value === '50'")
    browser.click(".configure input[type=checkbox]")
    browser.type(".configure select", "1")
    browser.type(".configure input[aria-label=frame]", "odom")
    wanted = {"rate": 50.0, "on": True, "mode": 1, "frame": "odom"}
    wait_for(lambda: {name: current.get(name) for name in wanted} == wanted)  # else the page's 50 may come after our 20
    server.update({"rate": 20.0})
    browser.run("document.activeElement.blur()")
    browser.wait("document.querySelector('.configure .num').value === '20'")


def test_reconfigure_as_its_command_opens_it(browser: Browser, web: Web, make_node: Make) -> None:
    tree = base64.urlsafe_b64encode(json.dumps({"panel": "params", "settings": {"reconfigure": ""}}).encode()).decode()
    browser.open(f"{web.link}#params={tree.rstrip('=')}")
    browser.wait_for_text("No node with dynamic_reconfigure is running")
    parameters = Parameters()
    outer = parameters.group("outer")
    parameters.group("inner", parent=outer).add("gain", 2)
    Server(make_node("motor"), parameters, lambda config, level: config)
    browser.wait("document.querySelector('.configure .num')?.value === '2'")
    names = "[...document.querySelectorAll('.configure summary')].map((each) => each.textContent).join()"
    assert browser.run(f"return {names}") == "outer,inner"


def wait_for(fits: Callable[[], bool]) -> None:
    tick = threading.Event()
    for _ in range(400):
        if fits():
            return
        tick.wait(0.05)
    raise AssertionError("it never came true")


def test_a_nodes_loggers_and_its_end(browser: Browser, web: Web, make_node: Make) -> None:
    node = make_node("worker")
    ended = threading.Event()
    node.on_shutdown(ended.set)
    browser.open(web.page("nodes"))
    choose(browser, "/worker")
    browser.wait("/process\\d+/.test(document.querySelector('.about').textContent)")
    browser.click("summary", "Levels of loggers")
    browser.wait("document.querySelector('details select')?.value === 'info'")
    browser.type("details select", "debug")
    browser.wait_for_text("is at debug")
    browser.click(".asking button", "Stop")
    browser.wait_for_text("Stop /worker?")
    assert not ended.is_set()
    browser.click(".asking button", "Yes")
    assert ended.wait(PATIENCE)
    browser.wait_for_text("this node is gone")


def test_a_node_that_is_started_again_has_its_new_address(browser: Browser, web: Web, make_node: Make) -> None:
    shown = "[...document.querySelectorAll('.details .mono')].some((each) => each.textContent === arguments[0])"
    first = make_node("robot")
    browser.open(panel_link(web.link, "nodes", {"selected": "/robot"}))
    browser.wait(shown, first.uri)
    first.shutdown()
    second = make_node("robot")
    assert second.uri != first.uri
    browser.wait(shown, second.uri)


def test_goals_of_an_action(browser: Browser, web: Web, make_node: Make) -> None:
    def execute(goal: Any) -> Any:
        for number in range(goal.goal.order):
            goal.feedback(FibonacciFeedback(sequence=[number]))
        while goal.goal.order == 99 and not goal.cancel_requested:
            threading.Event().wait(0.05)
        if goal.cancel_requested:
            goal.cancel(FibonacciResult())
            return None
        return FibonacciResult(sequence=[goal.goal.order])

    with SimpleServer(make_node("counter"), "fibonacci", FibonacciAction, execute):
        browser.open(web.page("nodes"))
        choose(browser, "/counter")
        browser.type(".action .form input", "7")
        browser.click(".action button", "Send goal")
        browser.wait("document.querySelector('.goal .status')?.textContent === 'succeeded'")
        browser.wait("document.querySelector('.goal').textContent.includes('result')")
        browser.type(".action .form input", "99")
        browser.click(".action button", "Send goal")
        browser.wait("document.querySelector('.goal .status')?.textContent === 'active'")
        browser.click(".goal button", "Cancel")
        browser.wait("document.querySelector('.goal .status')?.textContent === 'preempted'")
        assert browser.run("return document.querySelectorAll('.goal').length") == 2


def test_a_read_only_page_offers_no_changes(browser: Browser, start_web: Callable[..., Web], make_node: Make) -> None:
    node = make_node("worker")
    node.params["/a"] = 1
    web = start_web("--read-only")
    for panel, name in (("nodes", "/worker"), ("params", "/a"), ("services", "/worker/get_loggers")):
        browser.open(web.page(panel))
        browser.wait_for_text("read-only")
        if panel == "services":
            browser.click(".tools button", "Loggers")
        choose(browser, name)
        browser.wait("document.querySelector('.about')?.textContent.length > 10")
        words = browser.run(
            "return [...document.querySelectorAll('button')].filter((b) => b.offsetParent).map((b) => b.textContent)"
        )
        assert not {"Stop", "Save", "Delete", "Call", "New …"} & {*words}, panel


def test_the_keyboard_is_enough(browser: Browser, web: Web, make_node: Make) -> None:
    params = make_node("setter").params
    for name in ("/a/one", "/a/two", "/b"):
        params[name] = name
    press = "arguments[1] && document.querySelector(arguments[0]).dispatchEvent(" + (
        "new KeyboardEvent('keydown', {key: arguments[1], bubbles: true}))"
    )
    browser.open(web.page("params"))
    browser.wait(LINE.format("/a/two"))
    for key in ("ArrowDown", "ArrowLeft"):
        browser.run(press, ".table", key)
    browser.wait(f"!{LINE.format('/a/two')} && {LINE.format('/a/')}.getAttribute('aria-expanded') === 'false'")
    for key in ("ArrowRight", "ArrowDown"):
        browser.run(press, ".table", key)
    browser.wait("document.querySelector('.about .yaml')?.value === '/a/one'")
    browser.run(press, ".about", "Escape")
    browser.wait("document.querySelector('.details').hidden")
    browser.run(press, ".table", "/")
    browser.wait("document.activeElement === document.querySelector('input.search')")


def test_nothing_from_the_robot_becomes_markup(browser: Browser, web: Web, make_node: Make) -> None:
    evil = "<img src=x onerror=\"document.title='owned'\"><script>document.title='owned'</script>"
    node = make_node("worker")
    node.params["/evil"] = evil
    node.advertise("/text", "std_msgs/String", latch=True).publish(evil)
    for panel, name in (("params", "/evil"), ("topics", "/text")):
        browser.open(web.page(panel))
        choose(browser, name)
        browser.wait(
            "[...document.querySelectorAll('.about .yaml')].some((each) => each.value.includes('onerror')) || "
            "document.querySelector('.tree')?.textContent.includes('onerror')"
        )
        assert browser.run("return document.title").endswith(" \u2013 pyros1")
        assert browser.run("return document.querySelectorAll('.panel img, .panel script').length") == 0


def test_the_tables_fit_on_a_phone(browser: Browser, web: Web, make_node: Make) -> None:
    long = "/a/topic/with/quite/a/long/name/for/a/phone_" + "which_has_little_room_" * 3
    node = make_node("worker_" + "of_long_name_" * 6)
    node.advertise(long, "nav_msgs/Odometry", latch=True).publish()
    browser.resize(390, 800)
    browser.open(web.page("topics"))
    browser.wait(LINE.format(long))
    name = f"{LINE.format(long)}.querySelector('.name')"  # its end is seen: the begin of many is the same
    assert browser.run(f"return {name}.firstChild.getBoundingClientRect().right") < 390
    choose(browser, long)
    browser.wait_for_text("child_frame_id")
    assert browser.run(f"return {RIGHT}", ".inspector .actions button") < 390
    browser.click(".tab", "Publish")
    browser.wait("document.querySelectorAll('.form input').length > 5")
    assert browser.run("const e = document.querySelector('.details'); return e.scrollWidth - e.clientWidth") <= 0
    assert browser.run("return document.querySelector('.list').offsetParent") is None
    browser.click(".shut", "back")
    browser.wait("document.querySelector('.list').offsetParent")
    browser.open(panel_link(web.link, "plot", {"curves": [f"{long}/pose/pose/position/x"]}))
    browser.wait("document.querySelector('.chip button[aria-label^=remove]')")
    assert browser.run(f"return {RIGHT}", ".chip button[aria-label^=remove]") < 390
