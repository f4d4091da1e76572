"""The Python modules of sensor_msgs; its messages are in sensor_msgs.msg, as in all packages."""

from pyros1.drop_in.module_attributes import module_hooks

__getattr__ = module_hooks(__name__, lazy_imports={"msg": "sensor_msgs.msg.", "srv": "sensor_msgs.srv."})[0]
