"""What no known effect explains: its course in words and as a formula."""
