"""The package web_video_server: image topics as videos for browsers (https://wiki.ros.org/web_video_server)."""
