"""Optional conversions: of images, clouds and scans that are sent, and of names in messages that are received."""
