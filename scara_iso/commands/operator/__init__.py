"""Around a recording: questions, keys, the screen, and the watch."""
