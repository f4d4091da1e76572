"""The package map_server: map_server publishes a map from an image, map_saver saves one (https://wiki.ros.org/map_server)."""
