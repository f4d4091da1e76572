"""image_proc: pictures of cameras without Bayer pattern and without distortion (https://wiki.ros.org/image_proc)."""
