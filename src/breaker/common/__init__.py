"""What all rooms stand on: stores and files written whole, random numbers, numbers in words.

Nothing here knows of breakers, so it depends on nothing else of the package.
"""
