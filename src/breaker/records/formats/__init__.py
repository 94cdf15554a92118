"""The formats of curve files, each a module: see ``registry``."""
