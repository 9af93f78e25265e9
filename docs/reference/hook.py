"""Adds to the site the pages that are made from the program itself."""

import os
from pathlib import Path
import sys

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

sys.path.insert(0, str(Path(__file__).parent))

from api_pages import api_pages
from command_reference import command_reference
from error_reference import error_reference
from gallery import gallery
from metrics_reference import metrics_reference
from scenario_reference import scenario_reference


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the generated pages."""
    os.environ["COLUMNS"] = "96"
    pages = {
        "scenario_reference.md": scenario_reference(),
        "metrics_reference.md": metrics_reference(Path(config.docs_dir)),
        "command_reference.md": command_reference(),
        "error_reference.md": error_reference(),
        "gallery.md": gallery(Path(config.docs_dir)),
        **api_pages(),
    }
    for name, text in pages.items():
        files.append(File.generated(config, name, content=text))
    return files
