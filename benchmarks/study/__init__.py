"""What the program says of real readings, held against the readings that came next."""
