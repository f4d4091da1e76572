"""camera_info_manager, by pyros1: calibrations of cameras (https://wiki.ros.org/camera_info_manager_py)."""

from camera_info_manager.camera_info_manager import (
    CameraInfoError,
    CameraInfoManager,
    CameraInfoMissingError,
    genCameraName,
    getPackageFileName,
    loadCalibrationFile,
    parseURL,
    resolveURL,
    saveCalibration,
    saveCalibrationFile,
)
from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr(__name__)
