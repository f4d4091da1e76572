"""A program for stock's rospy and ours: subscribes to topics and says what came, as text.

Its first line of input is a JSON object with the type of each topic. To each further line it answers with a JSON
object: topic -> texts of its messages so far.
"""

from __future__ import annotations

import json
import logging
import sys

import roslib.message
import rospy

topics = json.loads(sys.stdin.readline())
rospy.init_node(sys.argv[1], disable_signals=True)
logging.getLogger("rosout").setLevel(logging.CRITICAL)
got: dict[str, list[str]] = {topic: [] for topic in topics}
for topic, kind in topics.items():
    cls = roslib.message.get_message_class(kind)
    rospy.Subscriber(topic, cls, lambda message, texts=got[topic]: texts.append(str(message)))
for _ in sys.stdin:
    print(json.dumps(got), flush=True)
