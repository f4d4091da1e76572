"""tf of stock and ours: Transformer, TransformerROS, transformations, and the registrations of tf2_ros."""

from __future__ import annotations

from faces import same
from harness import Master

MASTERS = ("ours",)  # these programs need no master; the fixture gives their environment

START = '''
import math, random, sys
import numpy as np
import rospy, tf, tf2_ros
from geometry_msgs.msg import *
from sensor_msgs.msg import PointCloud, ChannelFloat32
from std_msgs.msg import Header

def shown(value):
    """Numbers to nine digits, since the last bits depend on the order of operations."""
    if isinstance(value, np.ndarray):
        return "array%s %s" % (value.shape, shown(value.tolist()))
    if isinstance(value, (list, tuple)):
        return type(value).__name__ + "(" + ", ".join(map(shown, value)) + ")"
    if isinstance(value, (float, np.floating)):
        return "%.8f" % (value + 0.0 if abs(value) > 1e-9 else 0.0)
    if hasattr(value, "to_nsec"):
        return "%s ns" % value.to_nsec()
    if hasattr(value, "__slots__") and hasattr(value, "_slot_types"):
        fields = ((name, getattr(value, name)) for name in value.__slots__)
        kind = type(value).__name__.replace("Point32", "Point")  # the points of a cloud; stock makes the larger one
        return kind + "{" + ", ".join("%s: %s" % (name, shown(part)) for name, part in fields) + "}"
    return str(value)

def say(label, ask, *arguments, **named):
    try:
        print(label, shown(ask(*arguments, **named)))
    except Exception as error:
        print(label, type(error).__name__, *[] if isinstance(error, TypeError) else [error])

chance = random.Random(4)

def quaternion():
    parts = [chance.gauss(0, 1) for _ in range(4)]
    length = math.sqrt(sum(part * part for part in parts))
    return [part / length for part in parts]

def stamped(parent, child, seconds):
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id = parent, child
    message.header.stamp = rospy.Time.from_sec(seconds)
    message.transform.translation = Vector3(*[chance.uniform(-5, 5) for _ in range(3)])
    message.transform.rotation = Quaternion(*quaternion())
    return message
'''

TRANSFORMER = (
    START
    + """
transformer = tf.TransformerROS(True, rospy.Duration(10.0))
for step in range(9):
    for parent, child in (("map", "odom"), ("odom", "base"), ("base", "lidar"), ("map", "other")):
        transformer.setTransform(stamped(parent, child, 1.0 + step * 0.25), "me")
transformer.setTransform(stamped("/base", "/slash", 2.0))
names = ["map", "/map", "odom", "base", "/lidar", "other", "slash", "nope", ""]
for _ in range(150):
    target, source, fixed = (chance.choice(names) for _ in range(3))
    time, then = (rospy.Time.from_sec(chance.choice([0, 1, 1.5, 1.625, 2.9375, 3, 9])) for _ in range(2))
    say("can", transformer.canTransform, target, source, time)
    say("can full", transformer.canTransformFull, target, time, source, then, fixed)
    say("look", transformer.lookupTransform, target, source, time)
    if "" not in (target, source, fixed) and "nope" not in (target, source, fixed):
        say("look full", transformer.lookupTransformFull, target, time, source, then, fixed)
        say("common", transformer.getLatestCommonTime, target, source)
        if chance.random() < 0.5 and target.strip("/") != source.strip("/"):
            span = rospy.Duration.from_sec(chance.choice([0.125, 0.5, 1.0]))
            # angular velocities: stock's linear ones are wrong
            say("twist", lambda: transformer.lookupTwist(target, source, time, span)[1])
            point = (chance.uniform(-2, 2), 1.0, -1.0)
            say("full", lambda: transformer.lookupTwistFull(target, source, fixed, point, "map", time, span)[1])
    header = Header(5, time, source)
    say("matrix", transformer.asMatrix, target, header)
    x, y, z = (chance.uniform(-9, 9) for _ in range(3))
    say("point", transformer.transformPoint, target, PointStamped(header, Point(x, y, z)))
    say("vector", transformer.transformVector3, target, Vector3Stamped(header, Vector3(x, y, z)))
    turn = Quaternion(*quaternion())
    say("quaternion", transformer.transformQuaternion, target, QuaternionStamped(header, turn))
    say("pose", transformer.transformPose, target, PoseStamped(header, Pose(Point(x, y, z), turn)))
    points = [Point32(x, y, z), Point32(z, x, y)][: chance.randint(0, 2)]
    say("cloud", transformer.transformPointCloud, target, PointCloud(header, points, [ChannelFloat32("i", [2.0])]))
for name in ("map", "base", "/base", "lidar", "nope", ""):
    say("exists", transformer.frameExists, name)
say("names", sorted, transformer.getFrameStrings())
say("string", transformer.allFramesAsString)
say("dot", transformer.allFramesAsDot)
say("dot", transformer.allFramesAsDot, rospy.Time(5))
say("dot", transformer.allFramesAsDot, current_time=rospy.Time(5))
say("chain", transformer.chain, "map", rospy.Time(2), "lidar", rospy.Time(2), "map")
say("prefix", transformer.getTFPrefix)
say("wait", transformer.waitForTransform, "map", "base", rospy.Time(0), rospy.Duration(1))
say("wait", transformer.waitForTransformFull, "map", rospy.Time(0), "base", rospy.Time(0), "map", rospy.Duration(1))
say("make", transformer.fromTranslationRotation, (1, 2, 3), (0, 0, 0.6, 0.8))
say("cache", tf.Transformer, True, 10)
say("strip", tf.listener.strip_leading_slash, "//a")
say("mat", tf.listener.xyz_to_mat44, Point(1, 2, 3))
say("mat", tf.listener.xyzw_to_mat44, Quaternion(0, 0, 0.6, 0.8))
transformer.clear()
say("clear", transformer.canTransform, "map", "base", rospy.Time(0))
print(tf.Exception is tf2_ros.TransformException, tf.LookupException is tf2_ros.LookupException)
say("listener", tf.TransformListener)
from tf.msg import tfMessage
from tf.srv import FrameGraph
print(tfMessage._type, tfMessage._md5sum, FrameGraph._type, FrameGraph._md5sum)
"""
)

ARCBALL = (
    START
    + """
from tf import transformations as maths
from tf.transformations import *

print(sorted(maths._AXES2TUPLE.items()), sorted(maths._TUPLE2AXES.items()), maths._NEXT_AXIS, maths._EPS)
print(math.pi, numpy.pi)
for _ in range(60):
    matrix = random_rotation_matrix((0.1, 0.5, 0.7))
    initial = chance.choice([None, quaternion(), [part * 3 for part in quaternion()], matrix])
    ball = Arcball(initial) if chance.random() < 0.8 else Arcball(initial=initial)
    say("start", ball.matrix)
    if chance.random() < 0.7:
        ball.place([chance.uniform(0, 400), chance.uniform(0, 300)], chance.uniform(50, 400))
    if chance.random() < 0.6:
        ball.setaxes(*[[chance.uniform(-1, 1) for _ in range(3)] for _ in range(chance.randint(1, 3))])
    ball.setconstrain(chance.random() < 0.6)
    print(ball.getconstrain())
    for _ in range(3):
        ball.down([chance.uniform(-100, 500), chance.uniform(-100, 500)])
        for _ in range(3):
            ball.drag([chance.uniform(-100, 500), chance.uniform(-100, 500)])
            say("drag", ball.matrix)
        ball.next() if chance.random() < 0.5 else ball.next(acceleration=chance.uniform(-0.3, 0.3))
        say("next", ball.matrix)
    point = unit_vector([chance.gauss(0, 1) for _ in range(3)])
    axes = [unit_vector([chance.gauss(0, 1) for _ in range(3)]) for _ in range(3)]
    say("sphere", arcball_map_to_sphere, [chance.uniform(-9, 9), chance.uniform(-9, 9)], [1, 2], 5.0)
    say("axis", arcball_constrain_to_axis, point, axes[0])
    say("nearest", arcball_nearest_axis, point, axes)
say("same", arcball_constrain_to_axis, [0, 0, 1], [0, 0, 1])
say("same", arcball_constrain_to_axis, [1, 0, 0], [1, 0, 0])
for wrong in ([1, 2, 3], 5):
    try:
        Arcball(wrong)
    except (ValueError, TypeError) as error:
        print("wrong")
"""
)

REGISTRATIONS = (
    START
    + """
buffer = tf2_ros.Buffer(debug=False)
say("look", buffer.lookup_transform, "a", "b", rospy.Time(0))
say("can", buffer.can_transform, "a", "b", rospy.Time(0))
say("can", buffer.can_transform, "a", "b", rospy.Time(0), return_debug_tuple=True)
say("wait", buffer.lookup_transform, "a", "b", rospy.Time(0), rospy.Duration(0.1))
say("span", tf2_ros.Buffer, 3, False)
base = tf2_ros.BufferInterface()
say("base", base.lookup_transform, "a", "b", rospy.Time(0))
say("base", base.can_transform_full, 1, 2, 3, 4, 5)
say("error", lambda: (tf2_ros.TypeException("x").errstr, tf2_ros.NotImplementedException().errstr))

class Thing:
    pass

class Other:
    pass

thing = tf2_ros.Stamped(Thing(), rospy.Time(3), "map")
say("stamped", lambda: thing.header)
point = PointStamped(Header(0, rospy.Time(1), "b"), Point(1, 2, 3))
say("equal", tf2_ros.convert, point, PointStamped)
print(tf2_ros.convert(point, PointStamped) is point)
say("missing", tf2_ros.convert, 5, Thing)
buffer.set_transform(stamped("a", "b", 1.0), "me")
transforms = tf2_ros.TransformRegistration()
transforms.add(Thing, lambda it, transform: ("moved", transform.header.frame_id, transform.child_frame_id))
thing.header = Header(0, rospy.Time(1), "b")
say("moved", buffer.transform, thing, "a")
say("moved", buffer.transform, object_stamped=thing, target_frame="a", timeout=rospy.Duration(0))
say("moved", buffer.transform_full, thing, "a", rospy.Time(1), "a")
say("nowhere", buffer.transform, thing, "nope")
say("slash", buffer.transform, thing, "/a")
say("unknown", buffer.transform, 5, "a")
conversions = tf2_ros.ConvertRegistration()
conversions.add_convert((int, str), lambda number: "number %d" % number)
conversions.add_to_msg(Thing, lambda thing: PointStamped())
conversions.add_from_msg(Other, lambda message: ("from", type(message).__name__))
say("direct", tf2_ros.convert, 5, str)
say("by message", tf2_ros.convert, Thing(), Other)
say("full", buffer.lookup_transform_full, "a", rospy.Time(0), "b", rospy.Time(0), "a")
say("full", buffer.can_transform_full, "a", rospy.Time(0), "b", rospy.Time(0), "a", return_debug_tuple=True)
say("listener", tf2_ros.TransformListener, buffer)
"""
)


MATHS = (
    START
    + """
from tf.transformations import *

def axis():
    return [chance.gauss(0, 1) for _ in range(3)]

def rotation():
    return quaternion_matrix(quaternion())

for _ in range(100):
    a, b, c = (chance.uniform(-3, 3) for _ in range(3))
    order = chance.choice("sxyz sxyx sxzy szyx rxyz rzyx rzyz ryxy".split())
    p, q, v, w, m, n = quaternion(), quaternion(), axis(), axis(), rotation(), rotation()
    say("euler", euler_matrix, a, b, c, order)
    say("euler", euler_matrix, ai=a, aj=b, ak=c)
    say("angles", euler_from_matrix, m, order)
    say("angles", euler_from_quaternion, q, axes=order)
    say("quaternion", quaternion_from_euler, a, b, c, order)
    say("about", quaternion_about_axis, a, v)
    say("matrix", quaternion_matrix, q)
    say("of matrix", quaternion_from_matrix, m)
    say("product", quaternion_multiply, p, q)
    say("conjugate", quaternion_conjugate, q)
    say("inverse", quaternion_inverse, q)
    say("slerp", quaternion_slerp, p, q, 0.3)
    say("slerp", quaternion_slerp, p, q, 0.3, spin=1, shortestpath=False)
    say("random", random_quaternion, [0.1, 0.5, 0.9])
    say("random", random_rotation_matrix, [0.1, 0.5, 0.9])
    say("identity", identity_matrix)
    say("move", translation_matrix, v)
    say("moved", translation_from_matrix, translation_matrix(v))
    say("turn", rotation_matrix, a, v, w)
    angle, direction, point = rotation_from_matrix(rotation_matrix(a, v))
    say("turned", lambda: rotation_matrix(angle, direction, point))
    say("mirror", reflection_matrix, v, w)
    say("mirrored", lambda: reflection_matrix(*reflection_from_matrix(reflection_matrix(v, w))))
    say("scale", scale_matrix, a, v, w)
    say("scaled", lambda: scale_matrix(*scale_from_matrix(scale_matrix(a, v, w))))
    say("project", projection_matrix, v, w, direction=axis())
    say("project", projection_matrix, v, w, perspective=axis(), pseudo=True)
    say("projected", lambda: projection_matrix(*projection_from_matrix(projection_matrix(v, w))))
    say("clip", clip_matrix, -1, 2, -3, 4, 0.5, 9, perspective=chance.random() < 0.5)
    normal = numpy.cross(v, w)
    say("shear", shear_matrix, 0.4, v, w, normal)
    sheared = shear_matrix(0.4, unit_vector(v), [0, 0, 0], unit_vector(normal))
    say("sheared", lambda: len(shear_from_matrix(sheared)))  # stock's is sometimes off by half
    made = compose_matrix([1, 2, 3], [0.1, 0.2, 0.3], (a, b / 3, c), v)
    say("compose", lambda: made)
    say("decompose", decompose_matrix, made)
    say("orthogonal", orthogonalization_matrix, (10.0, 11.0, 12.0), (90.0, 80.0, 70.0))
    points = numpy.array([[chance.uniform(-1, 1) for _ in range(8)] for _ in range(3)])
    say("superimpose", superimposition_matrix, points, numpy.dot(m[:3, :3], points), False, True)
    say("chain", concatenate_matrices, m, n, made)
    say("inverse", inverse_matrix, made)
    say("same", is_same_transform, m, n)
    say("length", vector_norm, v)
    say("unit", unit_vector, [v, w], axis=1)
numpy.random.seed(3)
say("random", random_vector, 5)
"""
)


def test_functions_of_transformations(master: Master) -> None:
    assert "superimpose array(4, 4)" in same(master, MATHS)


def test_transformer_and_messages(master: Master) -> None:
    said = same(master, TRANSFORMER)
    for word in ("LookupException", "ExtrapolationException", "PoseStamped{", "twist tuple"):
        assert word in said


def test_arcball(master: Master) -> None:
    assert "nearest array(3,)" in same(master, ARCBALL)


def test_registrations_and_conversions(master: Master) -> None:
    assert "moved tuple(moved, a, b)" in same(master, REGISTRATIONS)
