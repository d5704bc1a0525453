"""A rehearsal: virtual hosts on one machine, on a network that chaos can impair."""
