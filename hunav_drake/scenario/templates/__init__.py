"""Small scenarios with comments, to begin one's own with."""

from importlib import resources


def list_templates() -> dict[str, str]:
    """Returns the names of the templates with their first lines."""
    folder = resources.files(__name__)
    names = sorted(
        entry.name.removesuffix(".yaml")
        for entry in folder.iterdir()
        if entry.name.endswith(".yaml")
    )
    return {
        name: template_text(name).splitlines()[0].removeprefix("# ")
        for name in names
    }


def template_text(name: str) -> str:
    """Returns the YAML of a template, with its comments.

    Raises:
        KeyError: If there is no such template.
    """
    file = resources.files(__name__) / f"{name}.yaml"
    if not file.is_file():
        raise KeyError(name)
    return file.read_text(encoding="utf-8")
