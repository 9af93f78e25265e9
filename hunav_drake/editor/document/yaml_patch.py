"""Changes the text of a scenario where its data changed, and nowhere else."""

from typing import Any

import yaml

from hunav_drake.editor.document.text_patch import Patches, difference
from hunav_drake.scenario.error import Loc
from hunav_drake.scenario.writer import _Dumper
from hunav_drake.scenario.yaml_document import YamlDocument


def patch_yaml(
    text: str, before: Any, after: Any, prefix: Loc, document: YamlDocument
) -> tuple[Patches, list[Loc]]:
    new = yaml.dump(after, Dumper=_Dumper, sort_keys=False, allow_unicode=True)
    return difference(text, new), [()]
