"""Messages: classes, texts, filling, checks, and the functions of genpy.message."""

import genpy, genpy.message as gm, io, copy, pickle
from genpy.message import *
import std_msgs.msg as sm, geometry_msgs.msg as geo, sensor_msgs.msg as sen, std_srvs.srv as ss, diagnostic_msgs.msg as dm


def show(f):
    try:
        r = f()
        return (type(r).__name__.replace("MessageType", "type"), str(r))
    except Exception as e:
        # ours say more: what the value is
        return (
            "!",
            type(e).__name__.replace("MessageException", "MessageError"),
            str(e).partition(", not ")[0].partition(", but ")[0],
        )


for v in ["x", b"x", 1, None, "a"]:
    print(isstring(v))
from genpy.base import is_simple, SIMPLE_TYPES, SIMPLE_TYPES_DICT

print(SIMPLE_TYPES, SIMPLE_TYPES_DICT, [is_simple(t) for t in ["int8", "string", "time", "uint8[]", "Header"]])
for cls in [
    sm.Header,
    geo.TwistStamped,
    sen.Image,
    sen.JointState,
    sen.PointCloud2,
    dm.DiagnosticArray,
    sm.Empty,
    sm.String,
    geo.PoseWithCovarianceStamped,
    sm.Time,
    ss.SetBoolRequest,
    ss.SetBoolResponse,
]:
    print(get_printable_message_args(cls()))
    print(
        cls.__slots__, cls._slot_types, cls()._get_types(), cls._type, cls._md5sum, cls._has_header, len(cls._full_text)
    )
    print(cls.__name__, cls.__module__, cls.__mro__[-2].__name__, cls)
    print(repr(cls()))
    print(str(cls()))
    print(strify_message(cls()))
    print(strify_message(cls(), indent="    "))
    print(
        cls() == cls(),
        cls() != cls(),
        cls() == 1,
        hasattr(cls(), "_connection_header"),
        show(lambda: cls()._connection_header),
        show(lambda: hash(cls())),
    )
    m = pickle.loads(pickle.dumps(cls()))
    print(m == cls())
    print(copy.deepcopy(m) == m, show(lambda: m.__getstate__()))
    print(show(lambda: setattr(m, "nope", 1)), show(lambda: m.nope))
    print(show(lambda: cls(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11)), show(lambda: cls(nope=1)), show(lambda: cls(1, nope=1)))
print(
    show(lambda: sm.String("x").serialize(1)),
    show(lambda: sm.String(1).serialize(io.BytesIO())),
    show(lambda: sm.String(None).serialize(io.BytesIO())),
)
print(
    show(lambda: sm.Int8(300).serialize(io.BytesIO())),
    show(lambda: sm.Int8("x").serialize(io.BytesIO())),
    show(lambda: sm.Int8(1.5).serialize(io.BytesIO())),
    show(lambda: sm.Float32("a").serialize(io.BytesIO())),
)
for t, v in [
    ("int8", 1),
    ("int8", 200),
    ("int8", -200),
    ("uint8", -1),
    ("uint8", 256),
    ("string", "a"),
    ("string", 1),
    ("bool", True),
    ("bool", 1),
    ("bool", 2),
    ("bool", "a"),
    ("float32", 1),
    ("float32", "x"),
    ("float64", 1.5),
    ("uint8[]", b"ab"),
    ("uint8[]", [1, 2]),
    ("uint8[]", [300]),
    ("int32[]", 1),
    ("int32[2]", [1, 2]),
    ("int32[]", "ab"),
    ("int32[]", ("a",)),
    ("std_msgs/Header", sm.Header()),
    ("std_msgs/Header[]", [sm.Header()]),
    ("int64", 2**63),
    ("int64", -(2**63)),
    ("uint64", 2**64 - 1),
    ("char", 5),
    ("byte", -5),
    ("int8", 1.0),
    ("string[]", ["a", 1]),
    ("Header", sm.Header()),
]:
    print(
        "check_type", t, repr(v) if not isinstance(v, genpy.Message) else v._type, show(lambda: check_type("f", t, v))
    )


def fill(m, args, keys={}):
    fill_message_args(m, args, keys)
    return m


for f in [
    lambda: fill(sm.String(), ["x"]),
    lambda: fill(sm.String(), [{"data": "x"}]),
    lambda: fill(sm.String(), ["a", "b"]),
    lambda: fill(sm.String(), []),
    lambda: fill(sm.String(), [{"nope": 1}]),
    lambda: fill(sm.String(), None),
    lambda: fill(sm.String(), "abc"),
    lambda: fill(sm.Header(), [1, 5, "a"]),
    lambda: fill(sm.Header(), [1, [5, 6], "a"]),
    lambda: fill(sm.Header(), [1, {"secs": 5}, "a"]),
    lambda: fill(sm.Header(), [1, "now", "a"], {"now": genpy.Time(9)}),
    lambda: fill(sm.Header(), [1, "nix", "a"], {"now": genpy.Time(9)}),
    lambda: fill(sm.Header(), [1, [1], "a"]),
    lambda: fill(sm.Header(), [1, {"x": 1}, "a"]),
    lambda: fill(geo.TwistStamped(), ["auto", [[1, 2, 3], [4, 5, 6]]], {"auto": sm.Header(frame_id="q")}),
    lambda: fill(
        geo.TwistStamped(), {"header": "auto", "twist": {"linear": {"x": 3}}}, {"auto": sm.Header(frame_id="q")}
    ),
    lambda: fill(sen.JointState(), {"name": ["a"], "position": [1, 2]}),
    lambda: fill(sm.Empty(), []),
    lambda: fill(sm.Empty(), {}),
    lambda: fill(sm.Empty(), None),
    lambda: fill(sm.Duration(), [-5]),
    lambda: fill(sm.Duration(), [[-5, 3]]),
    lambda: fill(sm.Time(), [{"secs": 1, "nsecs": 2 * 10**9}]),
    lambda: fill(sm.String(), [None]),
    lambda: fill(sm.Int8(), [None]),
]:
    print("fill", show(f))
t = geo.TwistStamped()
t.header.stamp = genpy.Time(100, 5)
print(strify_message(t, time_offset=genpy.Time(90)))
print(strify_message(t, current_time=genpy.Time(110)))
print(strify_message(t, field_filter=lambda m: ["twist"] if m._type.endswith("Stamped") else m.__slots__))
print(strify_message(t, fixed_numeric_width=9))
for v in [
    1,
    1.5,
    "a\nb",
    "",
    [1, 2],
    [],
    ["a", "b"],
    [True],
    genpy.Time(1, 2),
    genpy.Duration(-1, 3),
    (1.0, 2.0),
    b"ab",
    None,
    {"a": 1},
    [genpy.Time(1)],
    [sm.String("q")],
    [[1], [2]],
    True,
    "a: b",
    "\xe4",
    "x\ty",
]:
    print(
        "strify",
        show(lambda: strify_message(v)),
        show(lambda: strify_message(v, indent="  ")),
        show(lambda: strify_message(v, fixed_numeric_width=6)),
    )
print(
    strify_message(genpy.Time(5), time_offset=genpy.Time(3)), strify_message([genpy.Time(5)], time_offset=genpy.Time(3))
)
print(
    get_message_class("std_msgs/String") is sm.String,
    show(lambda: get_message_class("std_msgs/Nope")),
    show(lambda: get_message_class("nope/Nope")),
    show(lambda: get_message_class("String")),
    show(lambda: get_message_class("Header") is sm.Header),
    get_service_class("std_srvs/SetBool") is ss.SetBool,
    show(lambda: get_service_class("std_srvs/No")),
    show(lambda: get_service_class("x")),
)
print(genpy.struct_I.format, genpy.struct_I.size)
import numpy

b = io.BytesIO()
sen.PointCloud(points=[geo.Point32(1, 2, 3)]).serialize_numpy(b, numpy)
print(b.getvalue())
print(sen.JointState().deserialize_numpy(bytes(sen.JointState and b"\0" * 32), numpy))
b = io.BytesIO()
sen.LaserScan(
    ranges=numpy.array([1, 2, 3], dtype=numpy.float32), intensities=numpy.zeros(0, dtype=numpy.float32)
).serialize_numpy(b, numpy)
x = sen.LaserScan().deserialize_numpy(b.getvalue(), numpy)
print(type(x.ranges), x.ranges, x.ranges.dtype, x.ranges.flags.writeable)
y = sen.LaserScan().deserialize(b.getvalue())
print(type(y.ranges), y.ranges)
print(
    ss.SetBool._type,
    ss.SetBool._md5sum,
    ss.SetBool._request_class.__name__,
    ss.SetBool._response_class._type,
    ss.SetBoolRequest._md5sum,
    repr(ss.SetBoolRequest._full_text),
)
from std_msgs.msg._String import String

print(String is sm.String)
import std_msgs.msg._Header

print(std_msgs.msg._Header.Header is sm.Header)
from std_srvs.srv._SetBool import SetBool, SetBoolRequest

print(SetBool is ss.SetBool, SetBoolRequest is ss.SetBoolRequest)
