"""Verbs that change who moves a running robot."""
