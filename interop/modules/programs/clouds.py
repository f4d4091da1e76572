"""Point clouds: random ones, read and written."""

import sensor_msgs.point_cloud2 as pc2, numpy as np, math, struct, warnings
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header
import random


def show(f):
    try:
        r = f()
        return (type(r).__name__, str(r))
    except Exception as e:
        return ("!", type(e).__name__, str(e).replace("pack_into", "pack"))


c = pc2.create_cloud_xyz32(Header(frame_id="a"), [(1, 2, 3), (4, 5, float("nan"))])
print(c)
g = pc2.read_points(c)
print(type(g))
print(list(g))
print(type(next(pc2.read_points(c))))
print(pc2.read_points_list(c), type(pc2.read_points_list(c)[0]).__name__, pc2.read_points_list(c)[0]._fields)
print(
    list(pc2.read_points(c, skip_nans=True)),
    list(pc2.read_points(c, field_names=("z", "x"))),
    list(pc2.read_points(c, uvs=[(1, 0)])),
    list(pc2.read_points(c, field_names=["y"], uvs=[(0, 0), (1, 0)], skip_nans=True)),
)
print(
    show(lambda: list(pc2.read_points(3))),
    show(lambda: list(pc2.read_points(c, field_names=("nope",)))),
    show(lambda: list(pc2.read_points(c, uvs=[(5, 0)]))),
    show(lambda: pc2.create_cloud(Header(), [], [])),
    show(lambda: pc2.create_cloud_xyz32(Header(), [(1, 2)])),
    show(lambda: pc2.create_cloud_xyz32(Header(), np.ones((3, 3)))),
    show(lambda: pc2.create_cloud_xyz32(Header(), [])),
)
print(
    show(lambda: pc2.create_cloud_xyz32(Header(), [(1, 2, 3, 4)])),
    show(lambda: pc2.create_cloud_xyz32(Header(), [("a", 2, 3)])),
    show(lambda: pc2.create_cloud_xyz32(Header(), 3)),
    show(lambda: pc2.create_cloud_xyz32(Header(), iter([(1, 2, 3)]))),
    show(lambda: list(pc2.read_points(c, field_names="xyz"))),
    show(lambda: list(pc2.read_points(c, field_names="x"))),
)
r = random.Random(5)
sizes = {1: ("b", 1), 2: ("B", 1), 3: ("h", 2), 4: ("H", 2), 5: ("i", 4), 6: ("I", 4), 7: ("f", 4), 8: ("d", 8)}
for trial in range(60):
    fields = []
    off = 0
    for k in range(r.randrange(1, 7)):
        off += r.choice([0, 0, 0, 1, 3, 4])
        dt = r.randrange(1, 9)
        cnt = r.choice([1, 1, 1, 2, 3])
        fields.append(PointField(name="f%d" % k if r.random() < 0.9 else "rgb", offset=off, datatype=dt, count=cnt))
        off += sizes[dt][1] * cnt
    step = off + r.choice([0, 0, 4, 5])
    w = r.randrange(0, 6)
    h = r.randrange(1, 4)
    row = step * w + r.choice([0, 0, 8])
    if trial % 3 == 0:
        r.shuffle(fields)
    data = (
        bytes(r.randrange(256) for _ in range(row * h))
        if r.random() < 0.7
        else struct.pack("<f", float("nan")) * (row * h // 4) + b"\0" * (row * h % 4)
    )
    cl = PointCloud2(
        header=Header(),
        height=h,
        width=w,
        fields=fields,
        is_bigendian=r.random() < 0.3,
        point_step=step,
        row_step=row,
        data=data,
        is_dense=r.random() < 0.3,
    )
    names = [f.name for f in fields]
    sel = None if r.random() < 0.4 else r.sample(names, r.randrange(0, len(names) + 1))
    uv = [] if r.random() < 0.6 or not w else [(r.randrange(w), r.randrange(h)) for _ in range(3)]
    for skip in (False, True):
        print(trial, skip, show(lambda: [tuple(map(repr, p)) for p in pc2.read_points(cl, sel, skip, uv)]))
        print(
            show(lambda: pc2.read_points_list(cl, sel, skip, uv)),
            show(
                lambda: (
                    list(pc2.read_points(cl, field_names=sel, skip_nans=skip, uvs=uv))
                    == list(pc2.read_points(cl, sel, skip, iter(uv)) if False else pc2.read_points(cl, sel, skip, uv))
                )
            ),
        )
    types = [f for f in fields]
    pts = []
    for _ in range(r.randrange(0, 5)):
        p = []
        for f in sorted(fields, key=lambda f: f.offset):
            for _ in range(f.count):
                p.append(r.randrange(0, 100) if f.datatype < 7 else r.random() * 10)
        pts.append(p)
    print(show(lambda: pc2.create_cloud(Header(seq=trial), fields, pts)))
c2 = pc2.create_cloud(
    Header(),
    [PointField("x", 0, 7, 1), PointField("rgb", 16, 6, 1), PointField("d", 20, 8, 1)],
    [(1.5, 7, 2.5), (2.5, 8, float("inf"))],
)
print(c2)
print(pc2.read_points_list(c2))
print(pc2._DATATYPES, pc2._get_struct_fmt(False, c2.fields), pc2._get_struct_fmt(True, c2.fields, ["rgb"]))
