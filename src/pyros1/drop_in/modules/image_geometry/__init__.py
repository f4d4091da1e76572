"""image_geometry, by pyros1: pinhole cameras (https://wiki.ros.org/image_geometry)."""

from image_geometry.cameramodels import PinholeCameraModel, StereoCameraModel
from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr(__name__)
