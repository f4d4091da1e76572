"""Small names: registered definitions, remappings, comparisons, constants, loggers."""

import io
import logging
import logging.config
import os
import re
import sys
import warnings

warnings.simplefilter("ignore")
os.environ.setdefault("ROS_ROOT", "/usr/share/ros")
logging.setLoggerClass(logging.Logger)

import roslib.network
import rosbag.bag
import rosgraph.network
import rosgraph.roslogging
import rospy.names
import rospy.service
import rosunit.junitxml


def t(title, call):
    try:
        print(title, call())
    except Exception as error:
        print(title, type(error).__name__)


# Remappings before there is a node
rospy.names.reload_mappings(["x", "a:=b", "__name:=foo", "_p:=1"])
print(sorted(rospy.names.get_mappings().items()), rospy.names.get_resolved_mappings(), rospy.service.logger.name)

# rosbag.bag


class Age(rosbag.bag.ComparableMixin):
    def __init__(self, age):
        self.age = age

    def _cmpkey(self):
        return self.age


for one in range(3):
    a, b = Age(one), Age(1)
    print(a < b, a <= b, a == b, a != b, a >= b, a > b)
print(Age(1) == 1, Age(1) != 1, rosbag.bag.found_lz4, sorted(each.age for each in sorted([Age(3), Age(1)])))
t("order", lambda: Age(1) < 3)

# Constants
print(rosgraph.network.SIOCGIFADDR, roslib.network.SIOCGIFCONF)
print(rosgraph.network.python3, roslib.network.python3, rosunit.junitxml.python2)
print(rosunit.junitxml.invalid_char_replacer(re.search("[\x00-\x1f]", "a\x01b")))
for text in ("a", "\x00", "a\x0b", "\t\n\r", "\x1f", "\ufffe", "\uffff", "\ue000", "\xff"):
    print(ascii(text), bool(re.search(rosunit.junitxml.RE_XML_ILLEGAL, text)))

# Loggers
logger = rosgraph.roslogging.RospyLogger("mine")


print(logger.findCaller()[2], os.path.basename(logger.findCaller()[0])[:8], isinstance(logger, logging.Logger))
out, err = io.StringIO(), io.StringIO()
os.environ["ROSCONSOLE_FORMAT"] = "${severity} ${message} ${logger} ${function}"
logger.addHandler(rosgraph.roslogging.RosStreamHandler(False, out, err))
logger.setLevel(logging.INFO)


logger.info("to %s", "out")
logger.warning("to err")
logger.debug("nowhere")
print(repr(out.getvalue()), repr(err.getvalue()))
CONFIG = """
[loggers]
keys=root, rosout
[handlers]
keys=stream
[formatters]
keys=plain
[logger_root]
level=INFO
handlers=
[logger_rosout]
level=INFO
handlers=stream
propagate=1
qualname=rosout
[handler_stream]
class=rosgraph.roslogging.RosStreamHandler
level=DEBUG
formatter=plain
args=(True,)
[formatter_plain]
format=[%(name)s][%(levelname)s] %(asctime)s: %(message)s
"""
os.environ["ROSCONSOLE_FORMAT"] = "[${severity}]: ${message}"
logging.config.fileConfig(io.StringIO(CONFIG), disable_existing_loggers=False)
logging.getLogger("rosout.some").info("through the configured handler")
sys.stdout.flush()
