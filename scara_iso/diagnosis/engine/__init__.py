"""The engine: hypotheses are shapes and kernels; one evidence, one test, one naming."""
