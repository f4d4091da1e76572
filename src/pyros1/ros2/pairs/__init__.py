"""Which type of ROS 1 is which type of ROS 2: what was found, and what mapping files say."""
