"""The plant's process: it publishes the state, takes the commands and moves the robot."""
