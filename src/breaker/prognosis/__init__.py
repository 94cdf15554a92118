"""A life in the drive's own curves, followed to decisions; a fleet as a loop over drives."""
