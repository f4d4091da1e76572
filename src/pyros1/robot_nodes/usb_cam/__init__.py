"""usb_cam and cv_camera: publish camera images (https://wiki.ros.org/usb_cam, https://wiki.ros.org/cv_camera)."""
