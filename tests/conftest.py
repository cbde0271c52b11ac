"""Drawn examples take as long as the machine is busy, so none has a deadline; failures print how to repeat them."""

from hypothesis import HealthCheck, settings

settings.register_profile("posreal", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True)
settings.load_profile("posreal")
