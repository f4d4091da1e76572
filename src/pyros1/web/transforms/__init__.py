"""What views make of the robot's data before it goes to a page."""
