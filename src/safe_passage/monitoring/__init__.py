"""Obstacles around the robot, standing or moving, seen by any sensors (paper 000)."""
