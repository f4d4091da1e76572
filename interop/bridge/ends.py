"""Ends of topics that go from one site to another: a publisher and a subscriber, for rospy, stock's or ours.

    ends.py talk RATE IMAGE_RATE IMAGE_SIZE     publishes /small (Twist) and /image, with time and number
    ends.py listen PREFIX                       prints "small NUMBER AGE" or "image NUMBER AGE" for each message
    ends.py rosbridge URL PREFIX                the same, as a client of rosbridge (with websockets)

Ages are in seconds. Both ends must use one clock: they run in network namespaces of one machine.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from contextlib import suppress


def talk(rate: float, image_rate: float, image_size: int) -> None:
    """Publish until the node ends."""
    import rospy
    from geometry_msgs.msg import Twist
    from sensor_msgs.msg import CompressedImage

    rospy.init_node("talker")
    small = rospy.Publisher("/small", Twist, queue_size=10)
    image = rospy.Publisher("/image", CompressedImage, queue_size=2)
    data = bytes(image_size)

    def publish_images() -> None:
        number = 0
        pace = rospy.Rate(image_rate)
        while not rospy.is_shutdown():
            message = CompressedImage(format="jpeg", data=data)
            number += 1
            message.header.frame_id = f"{number} {time.time()!r}"
            image.publish(message)
            pace.sleep()

    if image_rate:
        threading.Thread(target=publish_images, daemon=True).start()
    print("ready", flush=True)
    number = 0
    pace = rospy.Rate(rate)
    while not rospy.is_shutdown():
        message = Twist()
        number += 1
        message.linear.x, message.linear.y = time.time(), number
        small.publish(message)
        pace.sleep()


def _print(kind: str, number: float, sent_at: float) -> None:
    print(f"{kind} {number:.0f} {time.time() - sent_at:.6f}", flush=True)


def _print_image(frame_id: str) -> None:
    number, sent_at = frame_id.split()
    _print("image", float(number), float(sent_at))


def listen(prefix: str) -> None:
    """Subscribe until the node ends."""
    import rospy
    from geometry_msgs.msg import Twist
    from sensor_msgs.msg import CompressedImage

    rospy.init_node("listener")
    rospy.Subscriber(f"{prefix}/small", Twist, lambda m: _print("small", m.linear.y, m.linear.x), queue_size=100)
    rospy.Subscriber(f"{prefix}/image", CompressedImage, lambda m: _print_image(m.header.frame_id), queue_size=10)
    print("ready", flush=True)
    rospy.spin()


def listen_to_rosbridge(url: str, prefix: str) -> None:
    """Subscribe as a client of rosbridge; connect again whenever the connection ends, as roslibpy does."""
    from websockets.exceptions import WebSocketException

    while True:
        with suppress(OSError, WebSocketException):
            _listen_once(url, prefix)
        time.sleep(1.0)


def _listen_once(url: str, prefix: str) -> None:
    import cbor2
    from websockets.sync.client import connect

    with connect(url, max_size=None, compression=None, open_timeout=5) as connection:
        for topic, kind in (("small", "geometry_msgs/Twist"), ("image", "sensor_msgs/CompressedImage")):
            request = {"op": "subscribe", "topic": f"{prefix}/{topic}", "type": kind, "compression": "cbor"}
            connection.send(json.dumps(request))
        print("ready", flush=True)
        for frame in connection:
            if isinstance(frame, str):
                continue
            message = cbor2.loads(frame)["msg"]
            if "linear" in message:
                _print("small", message["linear"]["y"], message["linear"]["x"])
            else:
                _print_image(message["header"]["frame_id"])


def main() -> None:
    """Run the end that the arguments name."""
    action, *arguments = sys.argv[1:]
    if action == "talk":
        talk(float(arguments[0]), float(arguments[1]), int(arguments[2]))
    elif action == "listen":
        listen(*arguments)
    else:
        listen_to_rosbridge(*arguments)


if __name__ == "__main__":
    main()
