"""A relay of twenty lines: what a message costs over TCP and zenoh, with nothing that a bridge does besides.

`python relay.py send ENDPOINT` sends what is published on /a; `python relay.py receive ENDPOINT` publishes it on
/robot0/a. It is what `cost.py` compares bridges with.
"""

from __future__ import annotations

import sys
from typing import Any

import zenoh

import pyros1
from pyros1.bridge.transport.zenoh_link import make_config
from pyros1.msgs import AnyMsg, load_message
from pyros1.wire.handshake import TopicType

KEY = "relay/a"


def main() -> None:
    """Relay until the node shuts down."""
    way, endpoint = sys.argv[1:3]
    node = pyros1.Node("relay", argv=[])
    sends = way == "send"
    mode, dial, listen = ("client", [endpoint], []) if sends else ("router", [], [endpoint])
    session: Any = zenoh.open(make_config(zenoh, mode, dial, listen, {}))
    if sends:
        out = session.declare_publisher(KEY, congestion_control=zenoh.CongestionControl.DROP)
        node.subscribe("/a", AnyMsg, lambda message: out.put(message._buff, attachment=bytes(40)))
    else:
        string = load_message("std_msgs/String")
        raw_type = TopicType(string._type, string._md5sum, string._full_text)
        publisher = node.advertise("/robot0/a", AnyMsg, queue_size=100, raw_type=raw_type)
        session.declare_subscriber(KEY, lambda sample: publisher.publish(AnyMsg(sample.payload.to_bytes())))
    node.spin()
    session.close()


if __name__ == "__main__":
    main()
