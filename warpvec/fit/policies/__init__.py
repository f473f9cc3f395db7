"""Policies: rules by which a fit adds and removes paths."""
