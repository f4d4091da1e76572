"""image_proc: debayers and rectifies camera images (https://wiki.ros.org/image_proc)."""
