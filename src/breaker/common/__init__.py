"""Documents, stores, model files, random numbers, numbers in words: nothing knows of breakers."""
