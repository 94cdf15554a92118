"""Numbers of the product at one point of its history, and a comparison with those of now."""
