"""What the named effects bring: error on unseen cycles, RP, shares of the variance."""
