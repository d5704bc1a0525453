"""A scripted person at the page of a real robot: what they decide, and how their hands do it."""
