"""The tables with a node on stock's rospy, actionlib and dynamic_reconfigure."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator

import pytest
from browsing import Browser, Web

PYTHON = "/usr/bin/python3"
NODE = """
import actionlib
import rospy
from actionlib.msg import TestAction, TestFeedback, TestResult
from diagnostic_msgs.msg import DiagnosticStatus
from dynamic_reconfigure.server import Server
from std_srvs.srv import SetBool

rospy.init_node("stock")
rospy.Service("/stock/switch", SetBool, lambda request: (request.data, "stock says hello"))
publisher = rospy.Publisher("/diagnosis", DiagnosticStatus, latch=True, queue_size=1)
publisher.publish(DiagnosticStatus(level=2, name="lamp", message="broken"))


def execute(goal):
    server.publish_feedback(TestFeedback(feedback=1))
    while goal.goal == 99 and not server.is_preempt_requested():
        rospy.sleep(0.05)
    if goal.goal == 99:
        server.set_preempted()
    else:
        server.set_succeeded(TestResult(result=goal.goal))


server = actionlib.SimpleActionServer("/counter", TestAction, execute, False)
server.start()


class Config:
    speed = dict(name="speed", type="double", default=1.0, min=0.0, max=5.0, level=1, description="m/s", edit_method="")
    config_description = dict(
        name="Default", type="", state=True, cstate="true", id=0, parent=0, parameters=[speed], groups=[],
        upper="DEFAULT", lower="groups", parentname="Default", parentclass="DEFAULT", field="DEFAULT::params",
    )
    min, max, defaults, level, type = {"speed": 0.0}, {"speed": 5.0}, {"speed": 1.0}, {"speed": 1}, {"speed": "double"}
    all_level = 1


Server(Config, lambda config, level: config)
rospy.spin()
"""


@pytest.fixture
def stock_node(environ: dict[str, str]) -> Iterator[None]:
    """A node on stock's libraries."""
    process = subprocess.Popen([PYTHON, "-c", NODE], env={**os.environ, **environ}, stdin=subprocess.DEVNULL)
    yield
    process.terminate()
    process.wait(20)


def choose(browser: Browser, name: str) -> None:
    find = f"[...document.querySelectorAll('.line')].find((line) => line.dataset.key === {name!r})"
    browser.wait(find)
    browser.run(f"{find}.querySelector('.cell').click()")


@pytest.mark.usefixtures("stock_node")
def test_a_stock_node_is_shown_and_changed(browser: Browser, web: Web) -> None:
    browser.open(web.page("topics"))
    choose(browser, "/diagnosis")
    browser.wait_for_text("broken")
    browser.wait("document.querySelector('.tree').textContent.includes('2ERROR')")

    browser.open(web.page("services"))
    choose(browser, "/stock/switch")
    browser.click(".caller button", "Call")
    browser.wait_for_text("stock says hello")

    browser.open(web.page("params"))
    browser.wait("document.querySelector(\".tools option[value='/stock']\")")
    browser.type(".tools select[aria-label='dynamic_reconfigure']", "/stock")
    browser.wait("document.querySelector('.configure .num')?.value === '1'")
    browser.type(".configure input[type=range]", "2.5")
    browser.wait("[...document.querySelectorAll('.line')].some((line) => line.textContent.includes('2.5'))")

    browser.open(web.page("nodes"))
    choose(browser, "/stock")
    for goal, status in (("7", "succeeded"), ("99", "active")):
        browser.type(".action .form input", goal)
        browser.click(".action button", "Send goal")
        browser.wait(f"document.querySelector('.goal .status')?.textContent === '{status}'")
    browser.click(".goal button", "Cancel")
    browser.wait("document.querySelector('.goal .status').textContent === 'preempted'")
    browser.click("summary", "Levels of loggers")
    browser.wait("document.querySelectorAll('details select').length > 3")
    browser.click(".asking button", "Stop")
    browser.click(".asking button", "Yes")
    browser.wait_for_text("this node is gone")
