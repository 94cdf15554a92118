"""Documents, stores, model files, random numbers and texts, independent of breakers."""
