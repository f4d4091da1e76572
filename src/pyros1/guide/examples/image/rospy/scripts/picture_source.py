#!/usr/bin/env python3
"""Publishes images like a camera: a bright square that moves over a dark background.

pyros1 run my_package picture_source.py
pyros1 web image --open                          displays them
"""

import numpy
import rospy
from sensor_msgs.msg import Image

WIDTH, HEIGHT, SIDE = 320, 240, 60  # pixels
SPEED = 40.0  # pixels/s


def picture(seconds):
    """Return an image as an array of shape (height, width, 3) with red, green and blue."""
    pixels = numpy.full((HEIGHT, WIDTH, 3), 40, dtype=numpy.uint8)
    left = int(SPEED * seconds) % (WIDTH - SIDE)
    top = (HEIGHT - SIDE) // 2
    pixels[top : top + SIDE, left : left + SIDE] = (255, 180, 60)
    return pixels


def main():
    rospy.init_node("picture_source")
    publisher = rospy.Publisher("image", Image, queue_size=1)
    rate = rospy.Rate(10.0)  # Hz
    while not rospy.is_shutdown():
        now = rospy.Time.now()
        pixels = picture(now.to_sec())
        image = Image(width=WIDTH, height=HEIGHT, encoding="rgb8", step=3 * WIDTH, data=pixels.tobytes())
        image.header.stamp = now
        image.header.frame_id = "camera"
        publisher.publish(image)
        rate.sleep()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C during sleep
