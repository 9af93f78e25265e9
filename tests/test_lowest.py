import pytest

from tests.lowest import lowest_versions


def test_the_lowest_versions_are_those_of_the_bounds():
    project = {
        "dependencies": ["drake>=1.56", "numpy>=2"],
        "optional-dependencies": {
            "completion": ["shtab>=1.7"],
            "dask": ["distributed[complete]>=2024.8"],
            "editor": [],
            "film": [],
            "notebook": [],
            "dev": ["pytest"],
        },
    }
    assert lowest_versions(project) == {
        "drake": "1.56",
        "numpy": "2",
        "shtab": "1.7",
        "distributed": "2024.8",
    }


def test_a_dependency_without_a_bound_is_an_error():
    with pytest.raises(ValueError, match="'numpy' has no lower bound"):
        lowest_versions(
            {"dependencies": ["numpy"], "optional-dependencies": {}}
        )
