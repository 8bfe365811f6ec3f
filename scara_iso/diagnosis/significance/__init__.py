"""Is there anything? Tests against other orders of the cycles, and against simulated scatter."""
