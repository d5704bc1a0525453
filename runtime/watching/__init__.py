"""Finding a robot that runs, seeing how its processes are, and controlling them."""
