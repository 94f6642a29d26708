"""File formats of height maps, one a file."""
