#!/usr/bin/env python3
"""Switches a lamp on and off with a timer, and stops with a second timer, which fires only once.

pyros1 run my_package blinker.py
pyros1 run my_package blinker.py _period:=0.1 _duration:=3
pyros1 topic echo lamp                           in another terminal
"""

import pyros1
from pyros1.msgs.std_msgs.msg import Bool


class Blinker:
    """Makes a lamp blink for a while."""

    def __init__(self, node, period, duration):
        self.node = node
        self.is_on = False
        self.lamp = node.advertise("lamp", Bool, queue_size=1, latch=True)
        self.timer = node.timer(period, self.blink)
        node.timer(duration, self.stop, oneshot=True)

    def blink(self, event):
        self.is_on = not self.is_on
        self.lamp.publish(Bool(self.is_on))
        delay = (event.current_real - event.current_expected).to_sec()
        self.node.log.info("%s, %.1f ms late", "on" if self.is_on else "off", 1000 * delay)

    def stop(self, event):
        self.timer.shutdown()
        self.lamp.publish(Bool(False))
        self.node.log.info("blinked long enough")
        self.node.shutdown()


with pyros1.Node("blinker") as node:
    Blinker(node, node.params.get("~period", 0.5), node.params.get("~duration", 60.0))  # s
    node.spin()
