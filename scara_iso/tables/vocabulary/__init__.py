"""What words, names of columns and sentences of a file mean; the sheet words.toml."""
