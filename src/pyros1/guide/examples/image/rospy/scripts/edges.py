#!/usr/bin/env python3
"""Finds edges in images with numpy: publishes how much the brightness changes at each pixel.

pyros1 run my_package edges.py                   receives images on image, publishes on edges
pyros1 run my_package edges.py image:=/camera/image_raw
pyros1 run my_package picture_source.py          publishes images if you have no camera
"""

import numpy
import rospy
from sensor_msgs.msg import Image

CHANNELS = {"mono8": 1, "rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4}


def brightness(image):
    """Return an array of shape (height, width) with values from 0 to 255; None if the encoding is not supported."""
    channels = CHANNELS.get(image.encoding)
    if channels is None:
        return None
    rows = numpy.frombuffer(image.data, dtype=numpy.uint8).reshape(image.height, image.step)  # a row may be padded
    pixels = rows[:, : image.width * channels].reshape(image.height, image.width, channels)
    return pixels[:, :, :3].mean(axis=2)


def on_image(image, publisher):
    grey = brightness(image)
    if grey is None:
        rospy.logwarn_once("images in %s are not supported, only: %s", image.encoding, ", ".join(CHANNELS))
        return
    down, right = numpy.gradient(grey)
    strength = numpy.clip(2 * numpy.hypot(down, right), 0, 255).astype(numpy.uint8)
    height, width = strength.shape
    # Keep the header: it contains the image's time and frame.
    publisher.publish(Image(image.header, height, width, "mono8", 0, width, strength.tobytes()))


if __name__ == "__main__":
    rospy.init_node("edges")
    publisher = rospy.Publisher("edges", Image, queue_size=1)
    # Only the newest image if images arrive too fast; buff_size must be large enough for a whole image.
    rospy.Subscriber("image", Image, on_image, publisher, queue_size=1, buff_size=2**24)
    rospy.spin()
