"""Lets tests register nodes that are gone after them."""

from contextlib import contextmanager

import pytest

from hunav_drake.systems.behavior.nodes import registry


@contextmanager
def restored():
    types = registry._TYPES
    before = dict(types)
    try:
        yield types
    finally:
        types.clear()
        types.update(before)


@pytest.fixture
def node_types():
    """The registered node types, as a dictionary that a test may change."""
    with restored() as types:
        yield types


@pytest.fixture(scope="module")
def module_node_types():
    """As `node_types`, for all the tests of a file."""
    with restored() as types:
        yield types
