import pytest

from tests.systems.crowd import crowds


@pytest.fixture(scope="session")
def make_snapshot():
    return crowds.make_snapshot


@pytest.fixture(scope="session")
def walk():
    return crowds.walk
