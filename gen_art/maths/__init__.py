"""Elementary functions, counter-based random numbers and noise, for kernels."""
