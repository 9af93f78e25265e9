"""The templates of pages."""

from jinja2 import Environment, PackageLoader, StrictUndefined


def template_environment() -> Environment:
    """Returns what renders the templates of this package."""
    return Environment(
        loader=PackageLoader("hunav_drake.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
