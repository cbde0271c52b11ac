"""What is asked: a vehicle, an objective, constraints, and what is free; layouts and designs as its answers."""
