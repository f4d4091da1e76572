"""cv_bridge, by pyros1: converts images to numpy arrays, as used by OpenCV (https://wiki.ros.org/cv_bridge).

Images in Bayer and YUV formats need OpenCV. Compressed images need OpenCV or Pillow.
"""

from cv_bridge.core import CvBridge, CvBridgeError
from cv_bridge.display import cvtColorForDisplay
from cv_bridge.encodings import getCvType
from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr(__name__)
