"""The nonlinear program of a problem, its coordinates, and the local searches over them."""
