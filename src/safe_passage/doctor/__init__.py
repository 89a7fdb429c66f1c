"""What is wrong with a running robot, in plain words: observations of its graph -> findings."""
