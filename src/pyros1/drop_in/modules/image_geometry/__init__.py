"""image_geometry, by pyros1: pinhole cameras (https://wiki.ros.org/image_geometry)."""

from image_geometry.cameramodels import PinholeCameraModel, StereoCameraModel
from pyros1.drop_in.missing import missing

__getattr__ = missing(__name__)
