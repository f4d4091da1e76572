"""cv_bridge: compressed images of every kind, read and written.

make FOLDER SEED: write files with OpenCV, Pillow, and PNG files of all kinds, made here; read FOLDER: print what
cv_bridge reads from the files in all encodings; write FOLDER SEED: write random images with cv_bridge.
"""

import io
import os
import random
import struct
import sys
import zlib

import numpy as np
from cv_bridge import CvBridge
from sensor_msgs.msg import CompressedImage

CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
DEPTHS = {0: (1, 2, 4, 8, 16), 2: (8, 16), 3: (1, 2, 4, 8), 4: (8, 16), 6: (8, 16)}
PASSES = [(0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)]
SIZES = [(1, 1), (5, 1), (1, 5), (3, 2), (11, 9)]
ENCODINGS = """passthrough bgr8 rgb8 bgra8 rgba8 mono8 mono16 bgr16 rgb16 bgra16 rgba16 8UC1 16UC1 8UC3 16UC3 8UC4 32FC3 8SC3
bayer_rggb8 yuv422 nope""".split()
FORMATS = ["png", "jpg", "jpeg", "bmp", "tiff", "webp", "pgm", "ppm", "PNG", "nope", "exr"]


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def nearest(left, above, corner):
    guess = left + above - corner
    return min((left, above, corner), key=lambda each: abs(guess - each))


def filtered(rows, size, dice):
    """Return rows of bytes as PNG stores them, each with a random filter."""
    found, before = bytearray(), None
    for row in rows:
        before = before or bytes(len(row))
        kind = dice.randrange(5)
        found.append(kind)
        for place, value in enumerate(row):
            left = row[place - size] if place >= size else 0
            corner = before[place - size] if place >= size else 0
            above = before[place]
            guess = [0, left, above, (left + above) // 2, nearest(left, above, corner)][kind]
            found.append((value - guess) & 255)
        before = row
    return bytes(found)


def packed(samples, bits):
    if bits == 16:
        return b"".join(struct.pack(">H", each) for each in samples)
    digits = "".join(format(each, "0%db" % bits) for each in samples)
    digits += "0" * (-len(digits) % 8)
    return bytes(int(digits[place : place + 8], 2) for place in range(0, len(digits), 8))


def png(dice, kind, bits, width, height, interlaced, clear):
    """Return a PNG file with random pixels."""
    channels = CHANNELS[kind]
    colours = min(1 << bits, 200) if kind == 3 else 1 << bits
    pixels = [[[dice.randrange(colours) for _ in range(channels)] for _ in range(width)] for _ in range(height)]
    raw = b""
    for x, y, across, down in PASSES if interlaced else [(0, 0, 1, 1)]:
        rows = [packed([each for pixel in row[x::across] for each in pixel], bits) for row in pixels[y::down]]
        raw += filtered(rows if width > x else [], max(1, channels * bits // 8), dice)
    head = struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, interlaced)
    found = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head)
    if kind == 3:
        found += chunk(b"PLTE", bytes(dice.randrange(256) for _ in range(3 * colours)))
    if clear and kind == 3:
        found += chunk(b"tRNS", bytes(dice.randrange(256) for _ in range(dice.randrange(1, colours + 1))))
    elif clear and kind in (0, 2):  # a colour that is in the picture
        found += chunk(b"tRNS", b"".join(struct.pack(">H", each) for each in pixels[0][0]))
    data = zlib.compress(raw)
    middle = len(data) // 2
    return found + chunk(b"IDAT", data[:middle]) + chunk(b"IDAT", data[middle:]) + chunk(b"IEND", b"")


def random_images(dice):
    for kind in ("u1", "u2", "i1", "i2", "i4", "f4", "f8"):
        for shape in ((7, 9), (1, 5), (5, 1), (1, 1), (6, 5, 1), (6, 5, 3), (1, 4, 3), (4, 1, 3), (1, 1, 4), (6, 5, 4)):
            size = int(np.prod(shape))
            if kind[0] == "u":
                values = [dice.randrange(256 ** int(kind[1])) for _ in range(size)]
            else:
                values = [dice.uniform(-300, 300) if kind[0] == "f" else dice.randrange(-120, 127) for _ in range(size)]
            yield kind, shape, np.array(values, kind).reshape(shape)


def saved(picture, form, **options):
    file = io.BytesIO()
    picture.save(file, form, **options)
    return file.getvalue()


def make(folder, dice):
    import cv2
    from PIL import Image

    files = {}
    for kind, depths in DEPTHS.items():
        for bits in depths:
            for interlaced in (0, 1):
                for clear in (0, 1) if kind in (0, 2, 3) else (0,):
                    for width, height in SIZES:
                        name = "png_%d_%d_%d_%d_%dx%d" % (kind, bits, interlaced, clear, width, height)
                        files[name] = png(dice, kind, bits, width, height, interlaced, clear)
    whole = files["png_2_16_0_0_11x9"]
    files["damaged_cut"], files["damaged_cut8"] = whole[:-30], files["png_2_8_0_0_11x9"][:-30]
    files["damaged_sum"] = whole[:-20] + bytes([whole[-20] ^ 1]) + whole[-19:]
    files["damaged_text"], files["more_behind"] = b"no picture", whole + b"more"
    for kind, shape, image in random_images(dice):
        if kind in ("u1", "u2"):
            for form in ("jpg", "bmp", "webp", "pgm", "ppm", "tiff"):
                if kind == "u2" and len(shape) > 2 and shape[2] > 1 and form in ("tiff", "ppm"):
                    continue  # only OpenCV can
                try:
                    files["%s_%s_%s" % (form, kind, "x".join(map(str, shape)))] = cv2.imencode("." + form, image)[
                        1
                    ].tobytes()
                except cv2.error:
                    pass
    colours = np.array([dice.randrange(256) for _ in range(24 * 20 * 4)], "u1").reshape(24, 20, 4)
    for quality in (40, 90):
        files["jpg_cmyk_%d" % quality] = saved(Image.fromarray(colours, "CMYK"), "JPEG", quality=quality)
    turned = Image.Exif()
    turned[0x112] = 6
    for name, mode, options in (
        ("progressive", "RGB", {"progressive": True}),
        ("turned", "RGB", {"exif": turned}),
        ("grey", "L", {}),
        ("full", "RGB", {"subsampling": 0}),
    ):
        files["jpg_" + name] = saved(Image.fromarray(colours).convert(mode), "JPEG", **options)
    for mode in ("1", "L", "P", "RGB"):
        for form in ("BMP", "TIFF", "WEBP", "PPM", "PNG"):
            if (mode, form) != ("P", "PPM"):
                files["%s_of_%s" % (form, mode)] = saved(Image.fromarray(colours[..., :3]).convert(mode), form)
    for mode, options in (
        ("LA", {}),
        ("RGBA", {}),
        ("RGBA", {"compression": "tiff_lzw"}),
        ("CMYK", {}),
        ("CMYK", {"compression": "tiff_deflate"}),
    ):
        for size in ((24, 20), (1, 5), (5, 1), (1, 1)):
            part = colours[: size[0], : size[1]]
            name = "tiff_%s_%d_%dx%d" % (mode, len(options), *size)
            picture = Image.fromarray(part) if mode != "CMYK" else Image.fromarray(part, "CMYK")
            files[name] = saved(picture.convert(mode), "TIFF", **options)
    clear = files["tiff_RGBA_0_24x20"]
    place = clear.index(struct.pack("<HHI", 338, 3, 1)) + 8
    colours[..., :3] = colours[..., :3].astype(int) * colours[..., 3:] // 255
    clear = saved(Image.fromarray(colours), "TIFF")
    files["tiff_multiplied"] = clear[:place] + bytes([1, 0]) + clear[place + 2 :]
    os.makedirs(folder)
    for name, data in files.items():
        with open(os.path.join(folder, name), "wb") as file:
            file.write(data)


def read(folder):
    bridge = CvBridge()
    for name in sorted(os.listdir(folder)):
        with open(os.path.join(folder, name), "rb") as file:
            message = CompressedImage(format="any", data=file.read())
        for encoding in ENCODINGS:
            try:
                image = bridge.compressed_imgmsg_to_cv2(message, encoding)
            except Exception:
                print(name, encoding, "error")
            else:
                found = image if image is None else (image.shape, str(image.dtype), image.tobytes().hex())
                print(name, encoding, found)


def write(folder, dice):
    bridge = CvBridge()
    os.makedirs(folder)
    for kind, shape, image in random_images(dice):
        for form in FORMATS:
            try:
                message = bridge.cv2_to_compressed_imgmsg(image, form)
            except Exception:
                continue
            assert message.format == form
            with open(os.path.join(folder, "%s_%s_%s" % (form, kind, "x".join(map(str, shape)))), "wb") as file:
                file.write(bytes(message.data))


words = sys.argv[1:]
{"make": make, "read": read, "write": write}[words[0]](words[1], *(random.Random(int(each)) for each in words[2:]))
