"""Processes that no robot needs, such as the page that people drive it by."""
