"""What every command shares: what it takes, its options, how it writes."""
