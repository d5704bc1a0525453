"""The processes of a robot: plant, goal source and agents."""
