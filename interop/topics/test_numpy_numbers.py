"""Values of numpy in all kinds of fields: what stock takes with Debian's numpy, we take with any."""

from __future__ import annotations

from faces import FACES, run
from harness import Master

MASTERS = ("ours",)

PROGRAM = """
import io, warnings
warnings.simplefilter("ignore")
import numpy
from geometry_msgs.msg import Point, Polygon, Point32, PoseWithCovariance
from sensor_msgs.msg import Imu, JointState, LaserScan
from std_msgs.msg import *
values = []
for number in (1, 1.5):
    for kind in "float64 float32 float16 int64 int32 uint8 int8 bool complex128 object longdouble".split():
        for shape in ((), (1,), (1, 1), (2,), (0,), (1, 2), (3, 1)):
            array = numpy.full(shape, number, dtype=kind)
            values += [(f"{number} {kind} {shape}", array), ("listed", [array]), ("three", [array] * 3)]
            values += [("two", (array, 1.0))]
values += [("matrix", numpy.matrix([[1.5], [2]])), ("masked", numpy.ma.array([1.5])), ("text", numpy.array(["1.5"]))]
values += [("no text", numpy.array(["x"])), ("none", numpy.array([None])), ("wide", numpy.array([1e300]))]
one = numpy.array([1.5])
values += [("column", numpy.ones((300, 1))), ("many", [one] * 300), ("nine", [one] * 9), ("36", numpy.ones((36, 1)))]
values += [("scalar", kind(1)) for kind in (numpy.float64, numpy.float32, numpy.int64, numpy.bool_)]
numbers = (Float32, Float64, Int8, UInt8, Int16, UInt16, Int32, UInt32, Int64, UInt64, Bool, Byte, Char)
others = (String, Time, Duration)
arrays = (Float32MultiArray, Float64MultiArray, Int32MultiArray, UInt64MultiArray, UInt8MultiArray, Int8MultiArray)
fields = [(cls, "data") for cls in (*numbers, *others, *arrays)]
fields += [(PoseWithCovariance, "covariance"), (JointState, "position"), (JointState, "name"), (Point, "y")]
fields += [(Header, "seq"), (LaserScan, "ranges"), (LaserScan, "range_max"), (Imu, "orientation_covariance")]
for cls, field in fields:
    for name, value in values:
        message = cls(**{field: value})
        if len(name) % 2:
            setattr(message, field, value)
        buffer = io.BytesIO()
        try:
            message.serialize(buffer)
            print(cls.__name__, field, name, buffer.getvalue().hex())
        except Exception:
            print(cls.__name__, field, name, "refused")
buffer = io.BytesIO()
Polygon([Point32(numpy.array([1.5]), 2, numpy.array([[3]]))] * 3).serialize(buffer)
print(buffer.getvalue().hex())
"""


def test_what_stock_takes_is_the_same(master: Master) -> None:
    stock, ours = (run(face, master, PROGRAM, timeout=120).splitlines() for face in FACES)
    taken = [(one, other) for one, other in zip(stock, ours, strict=True) if not one.endswith("refused")]
    assert len(taken) > 1000
    assert [one for one, _ in taken] == [other for _, other in taken]
