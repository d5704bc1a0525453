"""Deployment files: read with their places, checked, and written again."""
