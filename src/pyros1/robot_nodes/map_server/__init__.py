"""The package map_server: map_server publishes a map from a picture, map_saver writes one (https://wiki.ros.org/map_server)."""
