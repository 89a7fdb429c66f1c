"""Perception for mobile robots that share their space with people."""
