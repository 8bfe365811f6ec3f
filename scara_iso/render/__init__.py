"""How results look: the terminal, JSON. Each module is the one home of its package."""
