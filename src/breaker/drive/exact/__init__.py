"""The exact posterior of a record in a family of drives: the judge of what its networks answer."""
