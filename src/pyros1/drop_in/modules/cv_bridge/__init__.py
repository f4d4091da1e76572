"""cv_bridge, by pyros1: images as numpy arrays, as OpenCV wants them (https://wiki.ros.org/cv_bridge).

Only compressed images, and those of Bayer and YUV formats, need more: OpenCV, or for compressed ones Pillow.
"""

from cv_bridge.core import CvBridge, CvBridgeError
from cv_bridge.display import cvtColorForDisplay
from cv_bridge.encodings import getCvType
from pyros1.drop_in.missing import missing

__getattr__ = missing(__name__)
