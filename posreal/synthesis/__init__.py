"""The best positive-real device of any order for a problem, and what it is evidence of."""
