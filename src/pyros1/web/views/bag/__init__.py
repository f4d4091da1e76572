"""Views of bags: contents, messages, thumbnails of images, plots, playback and recording."""
