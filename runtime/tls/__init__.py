"""Certificates and private keys: making, moving and verifying them."""
