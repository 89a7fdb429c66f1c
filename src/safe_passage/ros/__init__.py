"""The only room that knows ROS: nodes convert, call an algorithm, publish."""
