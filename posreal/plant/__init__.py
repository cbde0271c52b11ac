"""A vehicle cut open: state space with ports, norms, quadrature, time responses; knows no vehicle."""
