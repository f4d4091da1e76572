"""cv_bridge: random images of each encoding, converted to each other one, and arrays of each type, made messages.

Usage: image_conversions.py SEED. Prints a line for each conversion.
"""

import random
import re
import struct
import sys

import numpy as np
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

ENCODINGS = """mono8 mono16 bgr8 rgb8 bgra8 rgba8 bgr16 rgb16 bgra16 rgba16 8UC1 8UC2 8UC3 8UC4 8SC1 8SC3 16UC1 16UC2 16UC3
16UC4 16SC1 16SC2 16SC3 32SC1 32SC3 32FC1 32FC2 32FC3 32FC4 64FC1 64FC2 bayer_rggb8 bayer_bggr8 bayer_gbrg8 bayer_grbg8
bayer_rggb16 bayer_bggr16 bayer_gbrg16 bayer_grbg16 yuv422 8UC nope""".split()
SIZES = [(1, 1), (1, 6), (5, 1), (4, 6)]
CHANNELS = {"mono": 1, "bgr": 3, "rgb": 3, "bgra": 4, "rgba": 4}
REAL = [0.0, -0.5, 1.5, 2.5, 254.5, 300.0, -7e4, 1e10, -1e10, 1e30, float("inf"), float("-inf"), float("nan")]


def layout(encoding):
    """Return bytes per number, channels, and whether the numbers are real."""
    match = re.match(r"(8|16|32|64)([USF])C([1-4])?$", encoding)
    if match:
        return int(match.group(1)) // 8, int(match.group(3) or 1), match.group(2) == "F"
    match = re.match(r"([a-z]+)(8|16)$", encoding)
    if match:
        return int(match.group(2)) // 8, CHANNELS[match.group(1)], False
    return (1, 2, False) if encoding.startswith("yuv") else (2 if encoding.endswith("16") else 1, 1, False)


def report(words, make):
    try:
        found = make()
    except Exception:
        found = "error"
    print(*words, found)


def as_text(image):
    data = image.tobytes()
    if image.dtype.kind == "f":  # all that is no number is the same
        data = np.where(np.isnan(image), np.float32(7e7), image).tobytes()
    return "%s %s %s" % (image.shape, image.dtype, data.hex())


def as_words(message):
    return "%d %d %s %d %d %s" % (
        message.height,
        message.width,
        message.encoding,
        message.step,
        message.is_bigendian,
        bytes(message.data).hex(),
    )


def main():
    dice = random.Random(sys.argv[1])
    bridge = CvBridge()
    for height, width in SIZES:
        for encoding in ENCODINGS:
            size, channels, real = layout(encoding)
            count = height * width * channels
            if real:
                numbers = [dice.choice(REAL) if dice.random() < 0.5 else dice.uniform(-400, 400) for _ in range(count)]
                data = struct.pack("<%d%s" % (count, "f" if size == 4 else "d"), *numbers)
            else:
                data = bytes(dice.randrange(256) for _ in range(count * size))
            turned = not real and dice.random() < 0.2
            message = Image(None, height, width, encoding, turned, width * channels * size, data)
            # OpenCV converts pairs of pixels of yuv422: of an odd width, it reads what lies behind the image.
            undefined = encoding == "yuv422" and width % 2
            for target in ["passthrough"] if undefined else ["passthrough", *ENCODINGS]:
                report(
                    (height, width, encoding, turned, target),
                    lambda to=target: as_text(bridge.imgmsg_to_cv2(message, to)),
                )
        for kind in ("u1", "i1", "u2", "i2", "i4", "f4", "f8", "?", "f2", "u4", ">u2"):
            for channels in (0, 1, 2, 3, 4, 5):
                shape = (height, width, channels) if channels else (height, width)
                image = np.array([dice.uniform(0, 120) for _ in range(int(np.prod(shape)))]).reshape(shape).astype(kind)
                for target in ["passthrough", *ENCODINGS]:
                    report((kind, shape, target), lambda to=target: as_words(bridge.cv2_to_imgmsg(image, to)))


main()
