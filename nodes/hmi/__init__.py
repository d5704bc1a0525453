"""The operator's page: a server that is a node of the robot, and what runs in the browser."""
