"""Formats of curve files, one module each; see ``detection``."""
