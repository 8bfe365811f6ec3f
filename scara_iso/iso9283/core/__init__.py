"""The core of the test: cycles that count, statistics, figures, drift, limits, results."""
