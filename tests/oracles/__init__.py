"""Independent computations that the tests and benchmarks hold the program against."""
