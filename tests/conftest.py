"""Drawn examples take as long as the machine is busy, so none has a deadline; failures print how to repeat them."""

import numpy  # noqa: F401  (the limit below reaches only libraries that are loaded)
import scipy.linalg  # noqa: F401
from hypothesis import HealthCheck, settings
from threadpoolctl import threadpool_limits

threadpool_limits(1)  # small matrices, and the tests run side by side already

settings.register_profile("posreal", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True)
settings.load_profile("posreal")
