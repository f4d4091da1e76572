"""The pyros1 side of the benchmarks, on the Node API: ``node_bench.py ROLE [QUEUE] [SECONDS] [SIZE]``."""

from __future__ import annotations

import sys
import threading
import time
from typing import Any

from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.msgs.std_srvs.srv import Empty, EmptyResponse

from pyros1 import Node

now = time.perf_counter


def wait_for_subscriber(node: Node, publisher: Any) -> None:
    while node.ok() and publisher.num_connections == 0:
        time.sleep(0.01)


def publish_floats(node: Node, queue_size: Any, seconds: float) -> None:
    publisher = node.advertise("bench", Float64, queue_size=queue_size)
    wait_for_subscriber(node, publisher)
    message, count, start = Float64(0.0), 0, now()
    while node.ok() and now() - start < seconds:
        message.data += 0.001
        publisher.publish(message)
        count += 1
    print(f"published {count / (now() - start):.0f} /s", flush=True)


def publish_images(node: Node, queue_size: Any, seconds: float, size: int) -> None:
    publisher = node.advertise("bench_img", Image, queue_size=queue_size)
    wait_for_subscriber(node, publisher)
    message = Image(height=1, width=size, step=size, encoding="mono8", data=bytes(size))
    count, start = 0, now()
    while node.ok() and now() - start < seconds:
        message.header.stamp = node.now()
        publisher.publish(message)
        count += 1
        if size > 100000:
            time.sleep(0.00005)
    print(f"published {count / (now() - start):.0f} /s", flush=True)


def receive(node: Node, topic: str, message_class: Any, queue_size: Any, seconds: float) -> None:
    count = received = 0

    def heard(message: Any) -> None:
        nonlocal count, received
        count += 1
        if message_class is Image:
            received += len(message.data)

    node.subscribe(topic, message_class, heard, queue_size=queue_size)
    print("ready", flush=True)
    while node.ok() and count == 0:
        time.sleep(0.01)
    start, first, first_bytes = now(), count, received
    time.sleep(seconds)
    took = now() - start
    print(f"received {(count - first) / took:.0f} /s  {(received - first_bytes) / took / 1e6:.1f} MB/s", flush=True)


def echo(node: Node, queue_size: Any) -> None:
    publisher = node.advertise("pong", Float64, queue_size=queue_size)
    node.subscribe("ping", Float64, publisher.publish, queue_size=queue_size)
    print("ready", flush=True)
    node.spin()


def ping(node: Node, queue_size: Any, seconds: float) -> None:
    answered = threading.Event()
    publisher = node.advertise("ping", Float64, queue_size=queue_size)
    subscriber = node.subscribe("pong", Float64, lambda _: answered.set(), queue_size=queue_size)
    wait_for_subscriber(node, publisher)
    while node.ok() and subscriber.num_connections == 0:
        time.sleep(0.01)
    times, message, start = [], Float64(0.0), now()
    while node.ok() and now() - start < seconds:
        answered.clear()
        sent = now()
        publisher.publish(message)
        if answered.wait(1):
            times.append(now() - sent)
        time.sleep(0.0005)
    times.sort()
    p50, p99 = times[len(times) // 2] * 1e6, times[len(times) * 99 // 100] * 1e6
    print(f"rtt us p50 {p50:.0f} p99 {p99:.0f} n {len(times)}", flush=True)


def call(node: Node, persistent: bool, seconds: float) -> None:
    node.wait_for_service("bench_srv")
    client = node.service("bench_srv", Empty, persistent=persistent)
    count, start = 0, now()
    while node.ok() and now() - start < seconds:
        client()
        count += 1
    print(f"calls {count / (now() - start):.0f} /s", flush=True)


def main() -> None:
    role, *rest = sys.argv[1:]
    queue_size = None if rest[:1] == ["None"] else int(rest[0]) if rest else 1000
    seconds = float(rest[1]) if len(rest) > 1 else 5.0
    size = int(rest[2]) if len(rest) > 2 else 0
    with Node("pyros1_" + role, anonymous=True, argv=[]) as node:
        if role == "pub":
            publish_floats(node, queue_size, seconds)
        elif role == "imgpub":
            publish_images(node, queue_size, seconds, size)
        elif role == "sub":
            receive(node, "bench", Float64, queue_size, seconds)
        elif role == "imgsub":
            receive(node, "bench_img", Image, queue_size, seconds)
        elif role == "echo":
            echo(node, queue_size)
        elif role == "ping":
            ping(node, queue_size, seconds)
        elif role == "srv":
            node.advertise_service("bench_srv", Empty, lambda _: EmptyResponse())
            print("ready", flush=True)
            node.spin()
        elif role == "call":
            call(node, bool(queue_size), seconds)
        else:
            sys.exit(f"unknown role {role}")


if __name__ == "__main__":
    main()
