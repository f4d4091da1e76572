"""tf_conversions, by pyros1: `transformations` and, if PyKDL is installed, conversions of its frames.

See https://wiki.ros.org/tf_conversions.
"""

from tf import transformations

from tf_conversions.posemath import __getattr__, fromCameraParams, fromMatrix, fromMsg, fromTf, toMatrix, toMsg, toTf
