"""Stores and files written whole, random numbers, numbers in words: nothing knows of breakers."""
