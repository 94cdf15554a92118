"""Studies of how good the package is. They use the package, which uses none of them."""
