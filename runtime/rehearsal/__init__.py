"""A rehearsal: the hosts of a deployment on one machine, on a network that can be broken."""
