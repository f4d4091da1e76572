"""Views of bags: contents, messages, pictures, plots, playback and recording."""
