"""ROS packages as files: what is where, what a package says about itself, who needs whom, and making new ones."""
