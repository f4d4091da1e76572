"""What a bridge changes in messages on request: images, clouds and scans that are sent; names in what is taken."""
