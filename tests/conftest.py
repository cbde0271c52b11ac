"""Drawn examples take as long as the machine is busy, so none has a deadline; failures print how to repeat them."""

import os
import sys

import numpy  # noqa: F401  (the limit below reaches only libraries that are loaded)
import pytest
import scipy.linalg  # noqa: F401
from hypothesis import HealthCheck, settings
from threadpoolctl import threadpool_limits

threadpool_limits(1)  # small matrices, and the tests run side by side already

settings.register_profile("posreal", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True)
settings.load_profile("posreal")


def pytest_addoption(parser: pytest.Parser) -> None:
    """What the campaign of :mod:`tests.fuzz` draws."""
    group = parser.getgroup("fuzz")
    for name, what in (("seed", "where the draws begin"), ("size", "draws of each kind")):
        default = int(os.environ.get(f"POSREAL_FUZZ_{name.upper()}", "0" if name == "seed" else "10"))
        group.addoption(f"--fuzz-{name}", type=int, default=default, help=f"{what} ({default} by default)")


@pytest.fixture
def without_pyplot(monkeypatch):
    """Whoever asks for pyplot, whose state is the user's, gets an ImportError; nor can the backend be chosen."""
    import matplotlib

    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    monkeypatch.setattr(matplotlib, "use", None)
