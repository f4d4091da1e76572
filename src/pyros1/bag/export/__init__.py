"""Files for other programs made of bags: pictures, videos, MCAP, ROS 2 bags; and bags made of the last two."""
