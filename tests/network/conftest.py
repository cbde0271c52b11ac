"""Drawn networks take as long as the machine is busy: no deadline for one example, and fewer of them."""

import pytest
from hypothesis import HealthCheck, settings

settings.register_profile(
    "networks", deadline=None, max_examples=700, suppress_health_check=[HealthCheck.too_slow]
)


@pytest.fixture(autouse=True, scope="package")
def _profile():
    before = settings.get_current_profile_name()
    settings.load_profile("networks")
    yield
    settings.load_profile(before)
