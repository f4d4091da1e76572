"""Messages of which the end is missing, at every length, and with lengths of strings that are too large."""

import io

import genpy
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseStamped
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import CompressedImage, JointState, Joy
from std_msgs.msg import ByteMultiArray, Header, Int8MultiArray, String, UInt8MultiArray
from std_srvs.srv import SetBoolResponse


def show(cls, data):
    try:
        message = cls().deserialize(data)
    except genpy.DeserializationError:
        print(cls._type, len(data), "no")
    else:
        print(cls._type, len(data), [getattr(message, name) for name in cls.__slots__])


for message in (
    String("grüße"),
    Header(seq=1, frame_id="base"),
    KeyValue("key", "value"),
    DiagnosticStatus(name="n", message="mm", hardware_id="h", values=[KeyValue("a", "bb"), KeyValue("cc", "ddd")]),
    CompressedImage(format="jpeg", data=b"12345678"),
    JointState(name=["a", "bcd"], position=[1.0, 2.0], effort=[3.0]),
    Joy(axes=[1.0], buttons=[1, 2]),
    Log(msg="text", name="nn", topics=["/a", "/bcd"]),
    UInt8MultiArray(data=b"12345"),
    Int8MultiArray(data=[1, 2, 3]),
    ByteMultiArray(data=[1, 2, 3]),
    PoseStamped(),
    SetBoolResponse(True, "done"),
):
    buffer = io.BytesIO()
    message.serialize(buffer)
    data = buffer.getvalue()
    for size in range(len(data) + 1):
        show(type(message), data[:size])
for size in (0, 3, 4, 2**31, 2**32 - 1):
    show(String, size.to_bytes(4, "little") + b"abc")
    show(KeyValue, size.to_bytes(4, "little") + b"abc")
