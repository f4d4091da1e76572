"""Cameras: image_geometry."""

import image_geometry, numpy as np, math
from image_geometry import PinholeCameraModel, StereoCameraModel
from sensor_msgs.msg import CameraInfo, RegionOfInterest
from std_msgs.msg import Header


def show(f):
    try:
        r = f()
        return np.round(np.asarray(r, float), 6).tolist() if not isinstance(r, (str, bytes)) and r is not None else r
    except Exception as e:
        return ("!", type(e).__name__, str(e)[:60])


import random

R = random.Random(4)


def info(dist=True, bx=0, by=0, roi=None, tx=0.0):
    fx, fy = 400 + R.random() * 100, 410 + R.random() * 100
    cx, cy = 320 + R.random(), 240 + R.random()
    return CameraInfo(
        header=Header(frame_id="cam"),
        width=640,
        height=480,
        distortion_model="plumb_bob",
        D=[R.uniform(-0.2, 0.2), R.uniform(-0.05, 0.05), 0.001, -0.002, 0.003] if dist else [0] * 5,
        K=[fx, 0, cx, 0, fy, cy, 0, 0, 1],
        R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
        P=[fx * 0.9, 0, cx + 1, tx, 0, fy * 0.9, cy - 1, 0, 0, 0, 1, 0],
        binning_x=bx,
        binning_y=by,
        roi=roi or RegionOfInterest(),
    )


for kw in (
    {},
    dict(dist=False),
    dict(bx=2, by=2),
    dict(bx=2, by=3, roi=RegionOfInterest(x_offset=10, y_offset=20, width=300, height=200)),
    dict(tx=-50.0),
):
    m = PinholeCameraModel()
    i = info(**kw)
    m.fromCameraInfo(i)
    for n in "Tx Ty cx cy fx fy fovX fovY distortionCoeffs fullIntrinsicMatrix fullProjectionMatrix fullResolution intrinsicMatrix projectionMatrix rotationMatrix tfFrame".split():
        print(n, show(getattr(m, n)))
    print(m.width, m.height, m.resolution, m.binning_x, m.binning_y, m.raw_roi, m.stamp, m.tf_frame)
    for _ in range(4):
        p = (R.uniform(-2, 2), R.uniform(-2, 2), R.uniform(0.5, 5))
        print(
            show(lambda: m.project3dToPixel(p)),
            show(lambda: m.projectPixelTo3dRay((R.uniform(0, 640), R.uniform(0, 480)))),
            show(lambda: m.getDeltaU(0.1, 2)),
            show(lambda: m.getDeltaV(0.1, 2)),
            show(lambda: m.getDeltaX(3, 2)),
            show(lambda: m.getDeltaY(3, 2)),
            show(lambda: m.getDeltaU(0.1, 0)),
        )
        print(show(lambda: m.rectifyPoint((R.uniform(100, 540), R.uniform(100, 380)))))
    print(
        type(m.K),
        type(m.project3dToPixel((1, 1, 1))),
        type(m.projectPixelTo3dRay((1, 1))),
        show(lambda: m.project3dToPixel((1, 1, 0))),
    )
s = StereoCameraModel()
l = info(dist=False)
r = CameraInfo()
import copy

r = copy.deepcopy(l)
r.P[3] = -40.0
s.fromCameraInfo(l, r)
print(
    show(lambda: s.project3dToPixel((0.1, 0.2, 2))),
    show(lambda: s.projectPixelTo3d((300, 200), 12.0)),
    show(lambda: s.getZ(5)),
    show(lambda: s.getDisparity(2)),
    show(lambda: s.getZ(0)),
    show(lambda: s.getDisparity(0)),
    s.tfFrame(),
    show(lambda: s.Q),
    s.left.fx() == s.right.fx(),
)

pixels = np.random.RandomState(3)
for coefficients in (
    [],
    [0.1, -0.05, 0.001, -0.002],
    [0.1, -0.05, 0.001, -0.002, 0.003],
    [0.2, 0.1, 0, 0, 0.01, 0.3, 0.02, 0.01],
):
    for turned in (False, True):
        i = info()
        i.D, i.width, i.height = coefficients, 64, 48
        i.K = [50.0, 0, 32, 0, 51, 24, 0, 0, 1]
        i.P = [45.0, 0, 33, 0, 0, 46, 23, 0, 0, 0, 1, 0]
        if turned:
            i.R = [0.99, 0.1, 0, -0.1, 0.99, 0, 0, 0, 1.0]
        m = PinholeCameraModel()
        m.fromCameraInfo(i)
        for channels in ((), (3,)):
            raw = pixels.rand(48, 64, *channels).astype(np.float32)
            rectified = np.zeros_like(raw)
            m.rectifyImage(raw, rectified)
            print(show(lambda: np.round(rectified[::6, ::7].astype(float), 2)))
            whole = (raw * 255).astype(np.uint8)
            rectified = np.zeros_like(whole)
            m.rectifyImage(whole, rectified)
            print(round(float(rectified.mean()) / 10), rectified.dtype, rectified.min(), rectified.max() > 200)
        for place in ((0, 0), (10, 20), (63.0, 47.0)):
            print(show(lambda: m.rectifyPoint(place)))
print(show(lambda: image_geometry.cameramodels.mkmat(2, 2, [1, 2, 3, 4])))
empty = PinholeCameraModel()
print(empty.distortionCoeffs(), empty.tfFrame(), StereoCameraModel().tfFrame(), empty.projectionMatrix())
