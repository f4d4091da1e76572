#!/usr/bin/env python3
"""An oscillator whose amplitude, frequency and shape can be changed while it is running.

pyros1 run my_package oscillator.py
pyros1 dynparam set oscillator amplitude 2.5
pyros1 dynparam set oscillator "{shape: square, frequency: 2.0}"
pyros1 web params --open                         changes them with sliders
"""

import math

import pyros1
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.reconfigure import Parameters, Server

SINE, SQUARE = 0, 1

parameters = Parameters()
parameters.add("amplitude", 1.0, "amplitude of the output", minimum=0.0, maximum=10.0)
parameters.add("frequency", 0.5, "frequency of the output in Hz", minimum=0.1, maximum=10.0)
parameters.add("shape", SINE, "shape of the output", choices={"sine": SINE, "square": SQUARE})


def on_configured(config, level):
    node.log.info("amplitude %.1f, frequency %.1f Hz", config.amplitude, config.frequency)
    return config  # the configuration to use, which may be corrected here


with pyros1.Node("oscillator") as node:
    server = Server(node, parameters, on_configured)
    publisher = node.advertise("output", Float64, queue_size=10)
    rate = node.rate(50.0)  # Hz
    phase = 0.0  # rad
    while node.ok():
        settings = server.config
        value = math.sin(phase)
        publisher.publish(
            Float64(settings.amplitude * (value if settings.shape == SINE else math.copysign(1.0, value)))
        )
        phase += 2 * math.pi * settings.frequency / 50.0
        rate.sleep()
