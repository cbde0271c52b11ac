"""Drawn networks take as long as the machine is busy, so no example has a deadline."""

from hypothesis import HealthCheck, settings

settings.register_profile("networks", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("networks")
