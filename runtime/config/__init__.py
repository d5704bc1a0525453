"""Deployment files: read with the location of each value, checked, and written again."""
