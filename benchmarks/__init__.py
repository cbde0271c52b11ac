"""What is timed, and against what: ratios of two ways of getting the same number, in one run on one machine."""
