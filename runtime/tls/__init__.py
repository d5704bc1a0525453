"""Certificates and private keys: how they are created, copied to other hosts and verified."""
