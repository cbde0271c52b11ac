"""Semidefinite programs, batched descent, parallel work: knows no mechanics."""
