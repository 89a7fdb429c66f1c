"""Worlds with exact truth: what cameras and lidars see in them."""
