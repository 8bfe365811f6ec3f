"""How a result looks: terminal, HTML, JSON, plots. What is said of it is decided elsewhere."""
