"""The Python modules of sensor_msgs; its messages are in sensor_msgs.msg, like those of all packages."""

from pyros1.drop_in.missing import names

__getattr__ = names(__name__, late={"msg": "sensor_msgs.msg.", "srv": "sensor_msgs.srv."})[0]
