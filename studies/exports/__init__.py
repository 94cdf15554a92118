"""Exports of analysers written at random, and what is read of them."""
