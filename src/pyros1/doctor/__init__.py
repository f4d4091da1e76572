"""What is wrong with a ROS system, and the cure: collectors find facts, pure checks make findings of them."""
