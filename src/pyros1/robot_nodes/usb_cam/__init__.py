"""usb_cam and cv_camera: images of cameras (https://wiki.ros.org/usb_cam, https://wiki.ros.org/cv_camera)."""
