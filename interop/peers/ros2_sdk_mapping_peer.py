"""A ROS 2 program, written with zenoh-ros2-sdk, with a type of its own, and with a log.

`python ros2_sdk_mapping_peer.py PORT LOG_HASH FLAT_HASH` logs ``hot 1``, ``hot 2`` and so on as errors, five times per
second, publishes the same numbers on ``/flat_from_ros2``, and prints what it gets on ``/flat_from_ros1``. It ends with
its input.
"""

from __future__ import annotations

import sys
import threading

import zenoh_ros2_sdk as sdk

TIME = f"{'=' * 80}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
LOG = "builtin_interfaces/Time stamp\nuint8 level\nstring name\nstring msg\nstring file\nstring function\nuint32 line\n"
FLAT = "builtin_interfaces/Time stamp\nfloat32 east\nfloat64 north\nstring extra\n"


def main() -> None:
    """Run until the input ends."""
    port, log_hash, flat_hash = sys.argv[1:]
    log = {"msg_type": "rcl_interfaces/msg/Log", "msg_definition": LOG + TIME, "type_hash": log_hash}
    flat = {"msg_type": "flat_interfaces/msg/Flat", "msg_definition": FLAT + TIME, "type_hash": flat_hash}
    where = {"router_ip": "127.0.0.1", "router_port": int(port), "node_name": "sdk_peer"}
    logger = sdk.ROS2Publisher("/rosout", **log, **where)
    talker = sdk.ROS2Publisher("/flat_from_ros2", **flat, **where)
    listener = sdk.ROS2Subscriber(
        "/flat_from_ros1",
        callback=lambda each: print("got", each.stamp.sec, each.east, each.north, repr(each.extra), flush=True),
        **flat,
        **where,
    )
    time_class = sdk.ZenohSession.get_instance().store.types["builtin_interfaces/msg/Time"]
    ended = threading.Event()

    def talk() -> None:
        number = 0
        while not ended.wait(0.2):
            number += 1
            stamp = time_class(sec=number, nanosec=0)
            logger.publish(
                stamp=stamp, level=40, name="sdk_peer", msg=f"hot {number}", file="a.py", function="f", line=3
            )
            talker.publish(stamp=stamp, east=0.5, north=float(number), extra="more")

    thread = threading.Thread(target=talk)
    thread.start()
    print("ready", flush=True)
    sys.stdin.read()
    ended.set()
    thread.join()
    for end in (logger, talker, listener):
        end.close()


if __name__ == "__main__":
    main()
