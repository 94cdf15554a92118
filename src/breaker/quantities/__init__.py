"""What is told of a drive, by name: parameters, sizes, speeds, and the quantities with limits."""
