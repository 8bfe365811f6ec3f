"""While a test runs: looks at the readings so far, with one level for all of them."""
