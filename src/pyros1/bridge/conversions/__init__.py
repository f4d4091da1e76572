"""Optional conversions: of images, clouds and scans before sending, and of names in received messages."""
