"""Recordings and scenes played as a live camera and lidar."""
