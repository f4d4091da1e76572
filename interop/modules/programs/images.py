"""Images: cv_bridge without OpenCV."""

import numpy as np, cv_bridge, sys
from cv_bridge import CvBridge, CvBridgeError
from sensor_msgs.msg import Image, CompressedImage
from std_msgs.msg import Header


def show(f):
    try:
        r = f()
        if isinstance(r, np.ndarray):
            return (r.shape, r.dtype.str, r.tolist() if r.size < 80 else int(r.astype(np.int64).sum()))
        return (type(r).__name__, str(r))
    except Exception as e:
        return ("!", type(e).__name__, str(e))


b = CvBridge()
r = np.random.RandomState(3)
encs = "rgb8 bgr8 rgba8 bgra8 mono8 mono16 bgr16 rgb16 bgra16 rgba16 8UC1 8UC2 8UC3 8UC4 8SC1 16UC1 16UC3 16SC2 32SC1 32FC1 32FC3 64FC1 64FC4 bayer_rggb8 bayer_bggr8 bayer_gbrg8 bayer_grbg8 bayer_rggb16 yuv422 nv21 nope".split()
for e in encs:
    print(e, show(lambda: b.encoding_to_cvtype2(e)), show(lambda: b.encoding_to_dtype_with_channels(e)))
for t in range(0, 32):
    print(t, show(lambda: b.cvtype2_to_dtype_with_channels(t)))
for d in ["uint8", "int8", "uint16", "int16", "int32", "float32", "float64", "uint32"]:
    for c in (1, 2, 3, 4, 5):
        print(d, c, show(lambda: b.dtype_with_channels_to_cvtype2(np.dtype(d) if 0 else d, c)))


def im(enc, h=3, w=4, big=0, pad=0):
    dt, c = b.encoding_to_dtype_with_channels(enc)
    dt = np.dtype(dt)
    a = (r.randint(0, 256, (h, w, c)) if dt.itemsize == 1 else r.randint(0, 60000, (h, w, c))).astype(dt)
    row = w * c * dt.itemsize
    data = b"".join(a[i].astype(dt.newbyteorder(">" if big else "<")).tobytes() + b"\7" * pad for i in range(h))
    return Image(height=h, width=w, encoding=enc, is_bigendian=big, step=row + pad, data=data)


ok = "rgb8 bgr8 rgba8 bgra8 mono8 mono16 bgr16 rgb16 bgra16 rgba16 8UC1 8UC2 8UC3 8UC4 16UC1 16UC3 16SC2 32SC1 32FC1 32FC3 64FC1 64FC4".split()
for e in ok:
    for big in (0, 1):
        for pad in (0,):
            m = im(e, big=big, pad=pad if np.dtype(b.encoding_to_dtype_with_channels(e)[0]).itemsize == 1 else 0)
            print(e, big, pad, show(lambda: b.imgmsg_to_cv2(m)))
    m = im(e)
    x = b.imgmsg_to_cv2(m)
    print(
        show(lambda: str(b.cv2_to_imgmsg(x))[:400]),
        show(lambda: b.cv2_to_imgmsg(x, e).encoding),
        show(lambda: b.cv2_to_imgmsg(x, e, Header(seq=4)).header.seq),
    )
    for d in "rgb8 bgr8 rgba8 bgra8 mono8 mono16 bgr16 rgb16 8UC1 8UC3 16UC1 32FC1 32FC3 passthrough".split():
        print(
            e,
            "->",
            d,
            show(lambda: b.imgmsg_to_cv2(m, d)),
            show(lambda: b.imgmsg_to_cv2(m, desired_encoding=d).flags.writeable),
        )
print(
    show(lambda: b.cv2_to_imgmsg(3)),
    show(lambda: b.cv2_to_imgmsg(np.zeros((2, 2, 3), np.uint8), "mono8")),
    show(lambda: b.cv2_to_imgmsg(np.zeros((2, 2), np.float64), "bgr8")),
    show(lambda: b.imgmsg_to_cv2(Image(encoding="nope", height=1, width=1, data=b"a", step=1))),
    show(lambda: b.cv2_to_imgmsg(np.zeros((2, 3), np.uint8)).encoding),
    show(lambda: b.cv2_to_imgmsg(np.zeros((2, 3, 1), np.uint8)).encoding),
    show(lambda: str(b.cv2_to_imgmsg(np.zeros((2, 3, 3), np.uint8)[:, ::2]))[-60:]),
    show(lambda: b.cv2_to_imgmsg(np.zeros((2, 2, 3), np.uint8), "nope")),
)
print(
    show(lambda: cv_bridge.getCvType("bgr8")),
    CvBridgeError.__mro__[1],
    show(lambda: b.imgmsg_to_cv2(Image())),
    show(lambda: b.imgmsg_to_cv2(im("bgr8", 1, 1))),
    show(lambda: b.imgmsg_to_cv2(im("mono8", 1, 1))),
    b.cvtype_to_name,
    b.numpy_type_to_cvtype,
    b.cvdepth_to_numpy_depth,
    b.cvtype_to_name.keys() == 0,
)
