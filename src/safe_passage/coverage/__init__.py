"""How many sensors see which part of a robot's surroundings, at which height."""
