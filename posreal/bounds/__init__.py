"""How far from the best possible: proven lower bounds over all positive-real devices."""
