"""Who moves the robot: agents, a person or nobody; and how fast near a person."""
