"""Small scenarios with comments, as starting points for users."""

from importlib import resources

from hunav_drake.systems.common.suggest import shown, suggestion


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
        ValueError: If there is no such template.
    """
    folder = resources.files(__name__)
    names = [entry.name for entry in folder.iterdir()]
    if f"{name}.yaml" not in names:
        valid = list(list_templates())
        raise ValueError(
            f"there is no template {shown(name)}; {suggestion(name, valid)}"
        )
    return (folder / f"{name}.yaml").read_text(encoding="utf-8")
