"""Networks held against each other, whole records and such with missing samples."""
