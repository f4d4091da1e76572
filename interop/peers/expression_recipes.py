"""Expressions as they are in public recipes, answers, READMEs and launch files; the words are ours."""

from __future__ import annotations

FILTERS = """
topic == '/odom'
topic=='/tf' or topic == "/odom"
topic != '/tf' and topic != '/image'
topic in ['/odom', '/scan']
topic in ('/odom', '/scan', '/nothing')
topic not in ["/tf", "/odom"]
not topic.startswith('/camera')
topic.startswith(('/o', '/s'))
topic.endswith('camera_info') or 'scan' in topic
topic.split('/')[1] == 'camera'
any(x in topic for x in ['tf', 'odom'])
any([topic == name for name in ['/tf', '/imu']])
topic[1:] in {'odom', 'imu'}
True
False
1
t.secs >= 3
t.secs <= 5.5
t.secs >= 2 and t.secs < 6
(t.secs >= 2) and (t.nsecs >= 0)
t.to_sec() >= 2.0 and t.to_sec() <= 5.0
2 <= t.to_sec() <= 5
t.to_time() > 4
t.to_time() - int(t.to_time()) < 0.5
t.to_nsec() % 2000000000 == 0
t.to_nsec() // 10**9 in range(3, 5)
float(str(t.secs)) > 3
abs(t.to_sec() - 4) < 1.5
topic != '/tf' or m.transforms[0].header.frame_id != 'map'
topic == '/tf' and m.transforms[0].header.frame_id == 'odom' and m.transforms[0].child_frame_id == 'base_link'
topic == '/tf' and (len(m.transforms) > 0 and m.transforms[0].child_frame_id == 'base_link')
topic == '/tf' and 'base_link' in [x.child_frame_id for x in m.transforms]
topic == '/tf' and any(tr.child_frame_id.lstrip('/') == 'base_link' for tr in m.transforms)
topic == '/tf' and all(tr.header.stamp.to_sec() > 1 for tr in m.transforms)
topic == '/tf' and len([tr for tr in m.transforms if tr.header.frame_id == 'map']) == 0
topic == '/tf' and len(list(filter(lambda x: x.child_frame_id == 'base_link', m.transforms))) > 0
topic == '/tf' and sorted(m.transforms, key=lambda tr: tr.header.stamp.to_sec())[0].header.frame_id == 'odom'
topic == '/odom' and m.pose.pose.position.x > 0.5
topic == '/odom' and (m.pose.pose.position.x**2 + m.pose.pose.position.y**2)**0.5 < 10
topic == '/odom' and abs(m.twist.twist.linear.x) > 1e-3
topic == '/odom' and m.header.seq % 2 == 0
topic == '/odom' and m.header.stamp.to_sec() < t.to_sec()
topic == '/odom' and (t - m.header.stamp).to_sec() > 0.1
topic == '/odom' and m.header.frame_id.strip('/') == 'odom'
topic == '/odom' and m.pose.pose.position.x == m.pose.pose.position.x
topic == '/odom' and m.pose.pose.position.x.is_integer()
topic == '/odom' and int(m.pose.pose.position.x) & 1
topic == '/odom' and sum(m.pose.covariance) == 0
topic == '/odom' and max(m.pose.covariance) < 1
hasattr(m, 'header')
hasattr(m, 'header') and m.header.frame_id == 'laser'
hasattr(m, 'header') and m.header.stamp.secs > 2
getattr(m, 'header', None) is not None
m._type == 'nav_msgs/Odometry'
m._type in ['nav_msgs/Odometry', 'sensor_msgs/LaserScan']
m._type != 'tf2_msgs/TFMessage'
m._type.startswith('sensor_msgs/')
'Laser' in m._type
m._type.split('/')[-1] == 'LaserScan'
m._has_header
'header' in m.__slots__
'std_msgs/Header' in m._slot_types
len(m._md5sum) == 32
'float32[] ranges' in m._full_text
not hasattr(m, 'nothing')
topic == '/scan' and min(m.ranges) < 0.5
topic == '/scan' and min([r for r in m.ranges if r > m.range_min]) < 0.6
topic == '/scan' and len(m.ranges) == 4
topic == '/scan' and m.ranges[len(m.ranges)//2] > 0.1
topic == '/scan' and any(map(lambda r: r > 1e3, m.ranges))
topic == '/scan' and float('inf') in m.ranges
topic == '/scan' and m.ranges.index(min(m.ranges)) == 1
topic == '/scan' and m.ranges.count(0.25) > 0
topic == '/diagnostics' and m.status[0].level >= 1
topic == '/diagnostics' and [True for s in m.status if s.level >= 1]
topic == '/diagnostics' and (m.status == [] or m.status[0].level == 2)
topic == '/diagnostics' and any('motor' in s.name.lower() for s in m.status)
topic == '/diagnostics' and dict((v.key, v.value) for v in m.status[0].values)['rpm'] == '100'
topic == '/diagnostics' and {v.key: v.value for v in m.status[0].values}.get('rpm', 0) == '100'
topic == '/diagnostics' and float(m.status[0].values[0].value) > 50
topic == '/joints' and 'elbow' in m.name
topic == '/joints' and m.position[m.name.index('elbow')] > 1
topic == '/joints' and dict(zip(m.name, m.position))['elbow'] > 1
topic == '/joints' and max(m.position, key=lambda x: -x) == 0.5
topic == '/text' and m.data == 'hello'
topic == '/text' and m.data.lower().find('hell') >= 0
topic == '/text' and int(m.data[-1:] == 'o')
topic == '/text' and m.data.encode('utf-8') == b'hello'
topic == '/text' and len(m.data.split()) == 1
topic == '/image' and m.encoding == 'mono8' and m.width * m.height > 3
topic == '/image' and len(m.data) == m.step * m.height
topic == '/image' and m.data[0] > 10
topic == '/image' and sum(m.data) / len(m.data) > 1
topic == '/camera/camera_info' and m.K[0] != 0
topic == '/imu' and (m.linear_acceleration.z > 9 if m.header.frame_id else False)
topic == '/imu' and m.orientation_covariance[0] == -1
(topic == '/odom' and 1) or (topic == '/imu' and 2)
not (topic == '/tf')
lambda x: x
print(topic)
print('%s %d' % (topic, t.secs)) or topic == '/odom'
print("{} {:.1f}".format(topic, t.to_sec())) is None
type(m).__name__ == 'nothing'
topic == '/text' and type(m.data) == str
isinstance(t.secs, int)
"""

ODOM, SCAN, IMU, JOINTS, TF = "/odom", "/scan", "/imu", "/joints", "/tf"
QUATERNION = "[m.orientation.x, m.orientation.y, m.orientation.z, m.orientation.w]"
POSE = "[m.pose.pose.orientation.x, m.pose.pose.orientation.y, m.pose.pose.orientation.z, m.pose.pose.orientation.w]"
TRANSFORMS: list[tuple[str, str, list[str]]] = [
    (ODOM, "m.pose.pose", []),
    (ODOM, "m.header, m.pose.pose", []),
    (ODOM, "[m.header, m.pose.pose]", []),
    (ODOM, "m.pose.pose.position.x", []),
    (ODOM, "numpy.rad2deg(m.pose.pose.position.x)", []),
    (ODOM, "-numpy.rad2deg(m.pose.pose.position.x)", ["numpy"]),
    (ODOM, "int(180 * (m.pose.pose.position.x + 1) / 2)", []),
    (ODOM, "numpy.linalg.norm([m.pose.pose.position.x, m.pose.pose.position.y])", []),
    (ODOM, "numpy.sqrt(numpy.sum(numpy.square([m.pose.pose.position.x, m.pose.pose.position.y])))", []),
    (ODOM, "numpy.hypot(m.twist.twist.linear.x, m.twist.twist.linear.y) * 3.6", []),
    (ODOM, "math.hypot(m.twist.twist.linear.x, m.twist.twist.linear.y)", ["math"]),
    (ODOM, "geometry_msgs.msg.Point(x=m.pose.pose.position.x, y=m.pose.pose.position.y, z=1)", ["geometry_msgs"]),
    (ODOM, "geometry_msgs.msg.Vector3(1, 2, 3)", ["geometry_msgs"]),
    (ODOM, "geometry_msgs.msg.PoseStamped(header=m.header, pose=m.pose.pose)", ["geometry_msgs"]),
    (
        ODOM,
        "geometry_msgs.msg.PoseStamped(header=std_msgs.msg.Header(seq=m.header.seq, stamp=m.header.stamp, "
        "frame_id='map'), pose=m.pose.pose)",
        ["geometry_msgs", "std_msgs"],
    ),
    (
        ODOM,
        "geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(x=max(-0.25, min(m.twist.twist.linear.x, 0.25))), "
        "angular=geometry_msgs.msg.Vector3(z=2 if m.pose.pose.position.x > 662 else 0))",
        ["geometry_msgs"],
    ),
    (ODOM, "m.header, (geometry_msgs.msg.Wrench(m.twist.twist.linear, m.twist.twist.angular))", ["geometry_msgs"]),
    (ODOM, f"tf.transformations.euler_from_quaternion({POSE})", ["tf"]),
    (ODOM, f"tf.transformations.euler_from_quaternion({POSE})[2]", ["tf.transformations", "tf"]),
    (ODOM, f"geometry_msgs.msg.Vector3(*tf.transformations.euler_from_quaternion({POSE}))", ["tf", "geometry_msgs"]),
    (ODOM, f"[*tf.transformations.euler_from_quaternion({POSE})]", ["tf"]),
    (ODOM, f"map(lambda x: x * 57.296, tf.transformations.euler_from_quaternion({POSE}))", ["tf"]),
    (ODOM, f"list(numpy.degrees(tf.transformations.euler_from_quaternion({POSE})))", ["tf"]),
    (ODOM, f"numpy.degrees(tf.transformations.euler_from_quaternion({POSE})).tolist()", ["tf"]),
    (
        ODOM,
        "geometry_msgs.msg.Quaternion(*tf.transformations.quaternion_from_euler(0, 0, 1.57))",
        ["tf", "geometry_msgs"],
    ),
    (ODOM, "tf.transformations.quaternion_matrix([0, 0, 0, 1])[:3, 3]", ["tf"]),
    (ODOM, "numpy.array(m.pose.covariance).reshape(6, 6)[0, 0]", []),
    (ODOM, "numpy.array(m.pose.covariance).reshape((6, 6)).diagonal()", []),
    (ODOM, "numpy.reshape(m.pose.covariance, (6, 6)).T.flatten().tolist()", []),
    (ODOM, "numpy.sqrt(numpy.diag(numpy.array(m.pose.covariance).reshape(6, -1)))", []),
    (ODOM, "numpy.zeros(36).tolist()", []),
    (ODOM, "(numpy.eye(6) * 0.1).ravel().tolist()", []),
    (ODOM, "numpy.identity(3).flatten()", []),
    (ODOM, "rospy.Duration(secs=0, nsecs=500000000)", ["rospy"]),
    (ODOM, "rospy.rostime.Duration(secs=0, nsecs=500000000)", ["rospy"]),
    (ODOM, "rospy.Time(5, 6)", ["rospy"]),
    (ODOM, "rospy.Time.from_sec(m.header.stamp.to_sec() + 1)", ["rospy"]),
    (ODOM, "m.header.stamp + rospy.Duration(1)", ["rospy"]),
    (ODOM, "std_msgs.msg.Header(stamp=m.header.stamp, frame_id=m.header.frame_id + '_2')", ["std_msgs"]),
    (ODOM, "'%.3f' % m.pose.pose.position.x", []),
    (ODOM, "'{:.3f} {}'.format(m.pose.pose.position.x, m.header.frame_id)", []),
    (ODOM, "str(m.header.seq)", []),
    (ODOM, "m._type", []),
    (IMU, f"tf.transformations.euler_from_quaternion({QUATERNION})", ["tf"]),
    (IMU, "numpy.sqrt(numpy.sum(numpy.array([m.angular_velocity.x, m.angular_velocity.y])))", []),
    (IMU, "numpy.cross([m.linear_acceleration.x, 0, 1], [0, 1, 0]).tolist()", []),
    (IMU, "numpy.arctan2(m.linear_acceleration.x, m.linear_acceleration.z)", []),
    (SCAN, "min(m.ranges)", []),
    (SCAN, "numpy.min(m.ranges)", []),
    (SCAN, "numpy.nanmin(numpy.array(m.ranges)[numpy.isfinite(m.ranges)])", []),
    (SCAN, "numpy.mean(m.ranges[1:3])", []),
    (SCAN, "numpy.median(m.ranges)", []),
    (SCAN, "numpy.percentile(m.ranges[:3], 50)", []),
    (SCAN, "numpy.clip(m.ranges, 0, 3).tolist()", []),
    (SCAN, "numpy.argmin(m.ranges) * m.angle_increment + m.angle_min", []),
    (SCAN, "numpy.where(numpy.array(m.ranges) > 1, 1, 0).tolist()", []),
    (SCAN, "numpy.flip(m.ranges).tolist()", []),
    (SCAN, "m.ranges[::-1]", []),
    (SCAN, "[r if r < 1 else 1.0 for r in m.ranges]", []),
    (SCAN, "numpy.linspace(m.angle_min, m.angle_max, 3).tolist()", []),
    (SCAN, "numpy.arange(len(m.ranges)).tolist()", []),
    (SCAN, "numpy.hstack([m.ranges, [1, 2]]).tolist()", []),
    (JOINTS, "m.position[m.name.index('elbow')]", []),
    (JOINTS, "dict(zip(m.name, m.position))['elbow']", []),
    (JOINTS, "list(map(math.degrees, m.position))", ["math"]),
    (JOINTS, "numpy.array(m.position).round(1).tolist()", []),
    (JOINTS, "numpy.dot(m.position, m.position)", []),
    (JOINTS, "sum(x * x for x in m.position)", []),
    (JOINTS, "' '.join(m.name)", []),
    (JOINTS, "sorted(m.name, key=lambda n: -len(n))", []),
    (JOINTS, "[2 * x for x in m.position if x.is_integer()]", []),
    (TF, "m.transforms[0].transform.translation", []),
    (TF, "[tr.child_frame_id for tr in m.transforms]", []),
    ("/image", "numpy.mean(numpy.frombuffer(m.data, dtype=numpy.uint8))", []),
    ("/image", "numpy.frombuffer(m.data, numpy.uint8).reshape(m.height, m.width).max(axis=0).tolist()", []),
    ("/text", "m.data.upper()", []),
    ("/text", "len(m.data)", []),
    ("/text", "m", []),
    (
        ODOM,
        "geometry_msgs.msg.PoseStamped(header=std_msgs.msg.Header(seq=m.header.seq, stamp=rospy.Time(0), "
        "frame_id='my_frame'), pose=geometry_msgs.msg.Pose(position=geometry_msgs.msg.Point(0,0,0), "
        "orientation=m.pose.pose.orientation))",
        ["geometry_msgs", "std_msgs", "rospy"],
    ),
    (
        ODOM,
        'geometry_msgs.msg.PointStamped(header=std_msgs.msg.Header(seq=0, frame_id="fcu"), '
        "point=geometry_msgs.msg.Point(m.pose.pose.position.x, m.pose.pose.position.y, m.pose.pose.position.z))",
        ["geometry_msgs", "std_msgs"],
    ),
    (ODOM, "geometry_msgs.msg.PoseArray(header=m.header, poses=[m.pose.pose])", ["geometry_msgs"]),
    (
        ODOM,
        "geometry_msgs.msg.Wrench(geometry_msgs.msg.Vector3(10.0*m.pose.covariance[0], -10.0*m.pose.covariance[1], 0), "
        "geometry_msgs.msg.Vector3(0, 0, 0))",
        ["geometry_msgs"],
    ),
    (
        JOINTS,
        'trajectory_msgs.msg.JointTrajectory(header=m.header, joint_names=["rev1","rev2"], points=['
        "trajectory_msgs.msg.JointTrajectoryPoint(positions=[0.6*m.position[0], -1*0.6*m.position[1]], "
        "time_from_start=rospy.rostime.Duration(secs=0,nsecs=500000000))])",
        ["trajectory_msgs", "rospy"],
    ),
    (
        JOINTS,
        "sensor_msgs.msg.JointState(header=m.header, name=[n + '_2' for n in m.name], position=m.position)",
        ["sensor_msgs"],
    ),
    (JOINTS, "std_msgs.msg.Float64MultiArray(data=m.position)", ["std_msgs"]),
    (JOINTS, "std_msgs.msg.Float64MultiArray(std_msgs.msg.MultiArrayLayout(), list(m.position))", ["std_msgs"]),
    (JOINTS, "std_msgs.msg.Float32(data=(float(m.position[0]) * 0.610351562 / 1000))", ["std_msgs"]),
    (JOINTS, "{n: p for n, p in zip(m.name, m.position)}['arm']", []),
    (JOINTS, "[p for n, p in sorted(zip(m.name, m.position))]", []),
    (JOINTS, "numpy.array(m.position)[[1, 0]].tolist()", []),
    (JOINTS, "numpy.matmul(numpy.eye(2), m.position).tolist()", []),
    (JOINTS, "(numpy.eye(2) @ numpy.array(m.position)).tolist()", []),
    (JOINTS, "numpy.inner(m.position, m.position)", []),
    (JOINTS, "numpy.vdot(m.position, m.position)", []),
    (JOINTS, "numpy.full(2, m.position[0]).tolist()", []),
    (JOINTS, "numpy.zeros_like(m.position).tolist()", []),
    (JOINTS, "numpy.average(m.position, weights=[1, 3])", []),
    (JOINTS, "numpy.float32(m.position[0])", []),
    (JOINTS, "pow(m.position[0], 2)", []),
    (JOINTS, "float(numpy.arccos(m.position[0]).round(3))", []),
    (JOINTS, "'%s: %.2f' % (m.name[0], m.position[0])", []),
    (JOINTS, "f'{m.name[0]:>8}={m.position[0]:.1f}'", []),
    (JOINTS, "any(abs(p) > 1 for p in m.position)", []),
    (SCAN, "numpy.histogram(m.ranges[:3], bins=3)[0].tolist()", []),
    (SCAN, "numpy.convolve(m.ranges[:3], [0.5, 0.5], 'valid').tolist()", []),
    (SCAN, "numpy.roll(m.ranges, len(m.ranges) // 2).tolist()", []),
    (SCAN, "numpy.array_split(m.ranges, 2)[0].tolist()", []),
    (SCAN, "numpy.split(numpy.array(m.ranges), 2)[1].tolist()", []),
    (SCAN, "numpy.flatnonzero(numpy.array(m.ranges) < 1).tolist()", []),
    (SCAN, "numpy.nanmean(numpy.where(numpy.isinf(m.ranges), numpy.nan, m.ranges))", []),
    (SCAN, "numpy.asarray(m.ranges).clip(m.range_min, 5).min()", []),
    (SCAN, "numpy.delete(m.ranges, 3).tolist()", []),
    (SCAN, "numpy.insert(m.ranges, 0, 0.5).tolist()", []),
    (SCAN, "numpy.concatenate((m.ranges[2:], m.ranges[:2])).tolist()", []),
    (SCAN, "numpy.isin([0.25, 3.0], m.ranges).tolist()", []),
    (SCAN, "numpy.fliplr([m.ranges])[0].tolist()", []),
    (
        SCAN,
        "sensor_msgs.msg.Range(header=m.header, radiation_type=sensor_msgs.msg.Range.INFRARED, range=min(m.ranges))",
        ["sensor_msgs"],
    ),
    (
        SCAN,
        "sensor_msgs.msg.LaserScan(m.header, m.angle_min, m.angle_max, m.angle_increment, m.time_increment, "
        "m.scan_time, m.range_min, m.range_max, [r for r in m.ranges], m.intensities)",
        ["sensor_msgs"],
    ),
    (IMU, "math.atan2(2*m.orientation.w*m.orientation.z, 1 - 2*(m.orientation.z**2))", ["math"]),
    (IMU, "numpy.linalg.norm([getattr(m.linear_acceleration, a) for a in 'xyz']) / 9.81", []),
    (IMU, "[getattr(m.orientation, a) for a in m.orientation.__slots__]", []),
    (
        IMU,
        f"tf.transformations.quaternion_multiply({QUATERNION}, "
        "tf.transformations.quaternion_about_axis(numpy.pi, (0, 0, 1))).tolist()",
        ["tf"],
    ),
    (IMU, f"tf.transformations.quaternion_inverse({QUATERNION}).tolist()", ["tf"]),
    (IMU, f"tf.transformations.euler_from_quaternion({QUATERNION}, 'rzyx')", ["tf"]),
    (IMU, f"tf.transformations.euler_from_quaternion({QUATERNION}, axes='sxyz')[0] * 180 / numpy.pi", ["tf"]),
    (
        TF,
        "geometry_msgs.msg.PoseStamped(m.transforms[0].header, geometry_msgs.msg.Pose(geometry_msgs.msg.Point("
        "m.transforms[0].transform.translation.x, m.transforms[0].transform.translation.y, 0), "
        "m.transforms[0].transform.rotation))",
        ["geometry_msgs"],
    ),
    (TF, "next(t for t in m.transforms if t.child_frame_id == 'odom').transform", []),
    ("/image", "sensor_msgs.msg.Image(m.header, m.height, m.width, '8UC1', 0, m.step, m.data)", ["sensor_msgs"]),
    ("/image", "numpy.frombuffer(m.data, 'u1')[::-1].tobytes()", []),
    ("/image", "bytes(bytearray(m.data)[:3])", []),
    ("/image", "len(m.data) / float(m.width * m.height)", []),
    ("/text", "std_msgs.msg.String(data=str(m.data))", ["std_msgs"]),
    ("/text", "m.data.replace('l', 'L').center(9, '*')", []),
    ("/text", "bool(m.data)", []),
    ("/text", "m.data == 'hello' and 1 or 0", []),
    ("/camera/camera_info", "numpy.reshape(m.K, (3, 3))[0, 0]", []),
    (
        "/camera/camera_info",
        "sensor_msgs.msg.CameraInfo(header=m.header,distortion_model=m.distortion_model,D=m.D,K=m.K,R=m.R,"
        "P=[381.4, 0.0, 320.5, 0.0, 0.0, 381.4, 240.5, 0.0, 0.0, 0.0, 1.0, 0.0])",
        ["sensor_msgs"],
    ),
    ("/diagnostics", "max([s.level for s in m.status])", []),
    ("/diagnostics", "'; '.join('%s=%s' % (v.key, v.value) for s in m.status for v in s.values)", []),
]

ARGUMENTS = {
    "n": "3",
    "x": "0.5",
    "sim": "true",
    "real": "false",
    "name": "robot1",
    "list": "[1, 2, 3]",
    "poses": "0 0 0.1",
    "empty": "",
    "model": "turtlebot3_burger",
    "yaw": "90",
    "path": "/maps/office.yaml",
    "map": "office",
    "range": "12.5",
    "e": "5",
}
EVALS = """
arg('sim') and not arg('real')
not arg('sim')
sim and not real
not (sim or real)
arg('sim') == True
arg('sim') == 1
str(arg('sim')).lower() == 'true'
arg('name') == 'robot1'
name == 'robot1' or name == 'robot2'
name in ['robot1', 'robot2']
arg('name') in ('a', 'b')
name != ''
arg('empty') == ''
arg('name') + '/base_link'
name + '_' + str(n)
'/' + arg('name') + '/camera'
"/" + name
'robot' + str(arg('n') - 1)
n + 1
arg('n') * 2
n > 2
int(arg('n')) >= 3
int(n) % 2 == 0
1 if n == 3 else 2
'a' if sim else 'b'
'a.launch' if arg('name') == 'robot1' else 'b.launch'
x * 2
-x
- arg('x')
x / n
n // 2
2 ** n
1.0 / x
float(x) * 3.14159265359 / 180
yaw * 3.14159265359 / 180
arg('yaw') / 180.0 * pi
poses.split()
poses.split(' ')[2]
float(poses.split()[2]) + 1
' '.join(poses.split())
list.split(',')[0]
list[1:-1].split(', ')[1]
len(list)
model.split('_')[1]
model.replace('_', '-')
model.upper()
model.startswith('turtlebot3')
'burger' in model
model[:6]
path.split('/')[-1]
path.split('/')[-1].split('.')[0]
path.endswith('.yaml')
'%s_%d' % (name, n)
'%.2f' % x
'{}_{}'.format(name, n)
'{0:03d}'.format(n)
f'{name}_{n}'
[i * 2 for i in range(n)]
max(n, 5)
min(1, x)
abs(-x)
round(x)
sum([1, 2, 3])
str(x)
bool(n)
n == 3 and x < 1
n is not None
dict(a=1, b=2)['a']
{'robot1': 5, 'robot2': 6}[name]
{'robot1': 5}.get(name, 0)
['zero', 'one', 'two', 'three'][n]
env('HOME')
optenv('NOTHING_OF_THIS', 'default')
env('HOME') + '/maps/' + name + '.yaml'
'; '.join(map(lambda i: name + str(i), range(n)))
'x' * n
True
not True
(n > 1) and (n < 5)
x == 0.5
'true' if n else 'false'
name.isdigit()
name[-1:].isdigit()
int(name[-1])
ord('a')
sorted([3, 1, 2])
map + '.yaml'
arg('map') == 'office'
range > 10
e < 3
sqrt(4) + floor(x)
radians(yaw)
sin(yaw * pi / 180)
any(i > 1 for i in [1, 2])
' '.join(map(str, [1]))
[str(i) for i in [1, 2]]
sorted(['b', 'aa'], key=lambda s: len(s))[0]
""".strip().splitlines()
