"""cv_bridge: images to be shown, and compressed ones."""

import re
import cv_bridge
import numpy as np
from cv_bridge import CvBridge
from sensor_msgs.msg import CompressedImage


def disp(im, *args):
    try:
        x = cv_bridge.cvtColorForDisplay(im, *args)
        return (x.shape, str(x.dtype), x.ravel().tolist()[:16])
    except Exception as e:
        return repr(e)[:300]


f = np.linspace(-1, 5, 16).reshape(4, 4).astype(np.float32)
fn = f.copy()
fn[0, 0] = np.nan
fi = f.copy()
fi[0, 1] = np.inf
fm = f.copy()
fm[0, 2] = -np.inf
fall = f * np.nan
g = (np.arange(16) * 3).reshape(4, 4).astype(np.uint8)
c = np.dstack([g, g, g])
for name, im, e in (
    ("f", f, "32FC1"),
    ("fn", fn, "32FC1"),
    ("fi", fi, "32FC1"),
    ("fm", fm, "32FC1"),
    ("fall", fall, "32FC1"),
    ("g", g, "8UC1"),
    ("g", g, "mono8"),
    ("c", c, "bgr8"),
    ("const", f * 0 + 2, "32FC1"),
    ("d", f.astype(np.float64), "64FC1"),
    ("u16", g.astype(np.uint16) * 300, "mono16"),
    ("s16", g.astype(np.int16) - 9, "16SC1"),
    ("c3", f[:, :, None].repeat(3, 2), "32FC3"),
):
    for a in (
        ("mono8", True),
        ("mono8", False, 1.0, 3.0),
        ("mono8", True, 1.0, 3.0),
        ("mono8", False, 3.0, 1.0),
        ("mono8", False, 2.0, 2.0),
        ("", False, 1.0, 3.0),
        ("mono8", False, 1.0),
        ("bgr8", True),
    ):
        print(name, e, a, disp(im, e, *a))
for e in "8UC2 8UC4 8SC3 16UC3 16SC3 32SC2 32SC3 32FC2 32FC4 64FC2 mono16 rgb16 bgra16 rgba16".split():
    ch = {"mono16": 1, "rgb16": 3, "bgra16": 4, "rgba16": 4, "bayer_grbg16": 1, "yuv422": 2}.get(e) or int(e[-1])
    dt = {"8U": "u1", "8S": "i1", "16": "u2", "32": "i4", "64": "f8"}.get(e[:2], "u2")
    if "32F" in e:
        dt = "f4"
    if "yuv" in e:
        dt = "u1"
    if "16S" in e:
        dt = "i2"
    im = np.ones((4, 4, ch) if ch > 1 else (4, 4), dt) * 3
    for out in ("", "bgr8", "mono8", "8UC3", "bgra8", "rgb16"):
        print(e, out, disp(im, e, out))
print(disp(g, "bgr8", "nope"))


def t(title, call, *arguments, **named):
    try:
        found = str(call(*arguments, **named))
    except Exception as error:
        found = f"{type(error).__name__}: {error}"
    print(title, re.sub(r" at 0x[0-9a-f]+", "", found).replace("\n", "|"), flush=True)


b = CvBridge()
a = (np.arange(8 * 8 * 3) % 251).reshape(8, 8, 3).astype(np.uint8)
g = (np.arange(64) * 3).reshape(8, 8).astype(np.uint8)
for name in ("png", "jpg", "jpeg", "bmp", "tiff", "webp"):
    for im in (a, g):
        t(
            "to " + name,
            lambda: (lambda m: (m.format, type(m).__name__, bytes(m.data[:2])))(b.cv2_to_compressed_imgmsg(im, name)),
        )
        if name in ("png", "bmp", "tiff") and im is a:
            for e in ("passthrough", "bgr8", "rgb8", "mono8", "bgra8"):
                t(
                    "back",
                    lambda: (lambda x: (x.shape, str(x.dtype), int(x.astype(int).sum())))(
                        b.compressed_imgmsg_to_cv2(b.cv2_to_compressed_imgmsg(im, name), e)
                    ),
                )
t("default", lambda: b.cv2_to_compressed_imgmsg(a).format)
t("wrong", lambda: b.cv2_to_compressed_imgmsg([1]))
t("wrong", lambda: b.cv2_to_compressed_imgmsg(None))
