#!/usr/bin/env python3
"""Publishes images like a camera: a bright square that moves over a dark background.

pyros1 run my_package picture_source.py
pyros1 web image --open                          displays them
"""

import numpy

import pyros1
from pyros1.msgs.sensor_msgs.msg import Image

WIDTH, HEIGHT, SIDE = 320, 240, 60  # pixels
SPEED = 40.0  # pixels/s


def picture(seconds):
    """Return an image as an array of shape (height, width, 3) with red, green and blue."""
    pixels = numpy.full((HEIGHT, WIDTH, 3), 40, dtype=numpy.uint8)
    left = int(SPEED * seconds) % (WIDTH - SIDE)
    top = (HEIGHT - SIDE) // 2
    pixels[top : top + SIDE, left : left + SIDE] = (255, 180, 60)
    return pixels


with pyros1.Node("picture_source") as node:
    publisher = node.advertise("image", Image, queue_size=1)
    rate = node.rate(10.0)  # Hz
    while node.ok():
        now = node.now()
        pixels = picture(now.to_sec())
        image = Image(width=WIDTH, height=HEIGHT, encoding="rgb8", step=3 * WIDTH, data=pixels.tobytes())
        image.header.stamp = now
        image.header.frame_id = "camera"
        publisher.publish(image)
        rate.sleep()
