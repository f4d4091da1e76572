#!/usr/bin/python3
"""The rospy side of the benchmarks: ``rospy_bench.py ROLE [QUEUE] [SECONDS] [SIZE]``; QUEUE may be ``None``.

Needs nothing but modules that answer to ``import rospy`` and to the messages' names.
"""

from __future__ import annotations

import sys
import threading
import time
from typing import Any

import rospy
from sensor_msgs.msg import Image
from std_msgs.msg import Float64
from std_srvs.srv import Empty, EmptyResponse

now = time.perf_counter


def wait_for_subscriber(publisher: Any) -> None:
    while not rospy.is_shutdown() and publisher.get_num_connections() == 0:
        time.sleep(0.01)


def publish_floats(queue_size: Any, seconds: float) -> None:
    publisher = rospy.Publisher("bench", Float64, queue_size=queue_size)
    wait_for_subscriber(publisher)
    message, count, start = Float64(0.0), 0, now()
    while not rospy.is_shutdown() and now() - start < seconds:
        message.data += 0.001
        publisher.publish(message)
        count += 1
    print(f"published {count / (now() - start):.0f} /s", flush=True)


def publish_images(queue_size: Any, seconds: float, size: int) -> None:
    publisher = rospy.Publisher("bench_img", Image, queue_size=queue_size)
    wait_for_subscriber(publisher)
    message = Image(height=1, width=size, step=size, encoding="mono8", data=bytes(size))
    count, start = 0, now()
    while not rospy.is_shutdown() and now() - start < seconds:
        message.header.stamp = rospy.Time.now()
        publisher.publish(message)
        count += 1
        if size > 100000:
            time.sleep(0.00005)
    print(f"published {count / (now() - start):.0f} /s", flush=True)


def receive(topic: str, data_class: Any, queue_size: Any, seconds: float, **options: Any) -> None:
    count = received = 0

    def heard(message: Any) -> None:
        nonlocal count, received
        count += 1
        if data_class is Image:
            received += len(message.data)

    rospy.Subscriber(topic, data_class, heard, queue_size=queue_size, tcp_nodelay=True, **options)
    print("ready", flush=True)
    while not rospy.is_shutdown() and count == 0:
        time.sleep(0.01)
    start, first, first_bytes = now(), count, received
    time.sleep(seconds)
    took = now() - start
    print(f"received {(count - first) / took:.0f} /s  {(received - first_bytes) / took / 1e6:.1f} MB/s", flush=True)


def echo(queue_size: Any) -> None:
    publisher = rospy.Publisher("pong", Float64, queue_size=queue_size, tcp_nodelay=True)
    rospy.Subscriber("ping", Float64, publisher.publish, queue_size=queue_size, tcp_nodelay=True)
    print("ready", flush=True)
    rospy.spin()


def ping(queue_size: Any, seconds: float) -> None:
    answered = threading.Event()
    publisher = rospy.Publisher("ping", Float64, queue_size=queue_size, tcp_nodelay=True)
    subscriber = rospy.Subscriber(
        "pong", Float64, lambda _: answered.set(), queue_size=queue_size, tcp_nodelay=True
    )
    wait_for_subscriber(publisher)
    while subscriber.get_num_connections() == 0:
        time.sleep(0.01)
    times, message, start = [], Float64(0.0), now()
    while not rospy.is_shutdown() and now() - start < seconds:
        answered.clear()
        sent = now()
        publisher.publish(message)
        if answered.wait(1):
            times.append(now() - sent)
        time.sleep(0.0005)
    times.sort()
    p50, p99 = times[len(times) // 2] * 1e6, times[len(times) * 99 // 100] * 1e6
    print(f"rtt us p50 {p50:.0f} p99 {p99:.0f} n {len(times)}", flush=True)


def call(persistent: bool, seconds: float) -> None:
    rospy.wait_for_service("bench_srv")
    client = rospy.ServiceProxy("bench_srv", Empty, persistent=persistent)
    count, start = 0, now()
    while not rospy.is_shutdown() and now() - start < seconds:
        client()
        count += 1
    print(f"calls {count / (now() - start):.0f} /s", flush=True)


def main() -> None:
    role, *rest = sys.argv[1:]
    queue_size = None if rest[:1] == ["None"] else int(rest[0]) if rest else 1000
    seconds = float(rest[1]) if len(rest) > 1 else 5.0
    size = int(rest[2]) if len(rest) > 2 else 0
    rospy.init_node("rospy_" + role, anonymous=True)
    if role == "pub":
        publish_floats(queue_size, seconds)
    elif role == "imgpub":
        publish_images(queue_size, seconds, size)
    elif role == "sub":
        receive("bench", Float64, queue_size, seconds)
    elif role == "imgsub":
        # without so large a buffer, rospy's bounded queue keeps nothing but the newest of each 64 KiB
        receive("bench_img", Image, queue_size, seconds, buff_size=2**24)
    elif role == "echo":
        echo(queue_size)
    elif role == "ping":
        ping(queue_size, seconds)
    elif role == "srv":
        rospy.Service("bench_srv", Empty, lambda _: EmptyResponse())
        print("ready", flush=True)
        rospy.spin()
    elif role == "call":
        call(bool(queue_size), seconds)
    else:
        sys.exit(f"unknown role {role}")


if __name__ == "__main__":
    main()
