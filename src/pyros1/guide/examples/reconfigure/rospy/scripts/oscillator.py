#!/usr/bin/env python3
"""An oscillator whose amplitude, frequency and shape can be changed while it is running.

pyros1 run my_package oscillator.py
pyros1 dynparam set oscillator amplitude 2.5
pyros1 dynparam set oscillator "{shape: square, frequency: 2.0}"
pyros1 web params --open                         changes them with sliders
"""

import math

import rospy
from dynamic_reconfigure.server import Server
from std_msgs.msg import Float64
from my_package.cfg import OscillatorConfig  # generated from cfg/Oscillator.cfg

RATE = 50.0  # Hz


def on_configured(config, level):
    rospy.loginfo("amplitude %.1f, frequency %.1f Hz", config.amplitude, config.frequency)
    return config  # the configuration to use, which may be corrected here


def main():
    rospy.init_node("oscillator")
    server = Server(OscillatorConfig, on_configured)
    publisher = rospy.Publisher("output", Float64, queue_size=10)
    rate = rospy.Rate(RATE)
    phase = 0.0  # rad
    while not rospy.is_shutdown():
        settings = server.config
        value = math.sin(phase)
        is_square = settings.shape == OscillatorConfig.Oscillator_square
        publisher.publish(settings.amplitude * (math.copysign(1.0, value) if is_square else value))
        phase += 2 * math.pi * settings.frequency / RATE
        rate.sleep()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C during sleep
