"""Writes pages from templates."""

import os
from pathlib import Path
from typing import Any
from urllib.parse import quote

from jinja2 import Environment, PackageLoader, StrictUndefined

from hunav_drake.systems.common.files import atomic_write


def write_page(filename: Path, template: str, **content: Any) -> Path:
    """Writes a page atomically.

    Args:
        filename: The file to write; an existing one is replaced.
        template: The name of a template of this package.
        content: The variables of the template.

    Returns:
        The path of the file.

    Raises:
        OSError: If it cannot be written.
    """
    environment = Environment(
        loader=PackageLoader("hunav_drake.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    text = environment.get_template(template).render(**content)
    with atomic_write(filename) as file:
        file.write(text.encode())
    return filename


def address_of(target: str | Path, page: Path) -> str:
    """Returns the address of a file, relative to a page."""
    path = os.path.relpath(target, page.parent)
    return quote(Path(path).as_posix())
