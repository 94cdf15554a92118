"""How good the product is: studies beside the package, which they use and which knows none."""
