"""The command `hunav edit`."""

import argparse
import contextlib
from pathlib import Path
from typing import Any

from hunav_drake.commands.errors import DONE, input_errors
from hunav_drake.commands.options import add_import_option, whole_number
from hunav_drake.systems.common.input_error import InputError

_EXTRA = "hunav edit needs tornado: pip install 'hunav_drake[editor]'"


def add_edit_options(edit: argparse.ArgumentParser) -> None:
    """Adds the options of `hunav edit`."""
    edit.description = (
        "Opens the scenario editor in the browser: a map to place people,"
        " goals, walls and the robot, forms for all other options, and runs."
        " Only this machine can connect to it. It ends with Ctrl-C, or half a"
        " minute after its last page is closed."
    )
    edit.set_defaults(function=_edit)
    edit.add_argument(
        "file",
        nargs="?",
        help="a file, or the name of a shipped scenario (default: the editor"
        " shows templates)",
    )
    edit.add_argument(
        "--name", help="the scenario to edit, if the file holds several"
    )
    edit.add_argument(
        "--template",
        metavar="T",
        help="start from a template: corridor, crossing, office, cafe or room",
    )
    edit.add_argument(
        "--map",
        type=Path,
        metavar="M",
        help="show a map of ROS 2's map_server (.yaml) as background",
    )
    edit.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="keep the results of runs in DIR (default: they are deleted when"
        " the editor ends)",
    )
    edit.add_argument(
        "--port",
        type=whole_number(0, "65536"),
        metavar="P",
        help="the port on 127.0.0.1; 0 for any free one (default: a fixed port"
        " for each file, if it is free)",
    )
    edit.add_argument(
        "--no-browser",
        action="store_true",
        help="print the address, but do not open a browser",
    )
    add_import_option(edit)


def _edit(options: argparse.Namespace) -> int:
    try:
        from hunav_drake.editor.page import EditPage
    except ModuleNotFoundError as error:
        if (error.name or "").split(".")[0] != "tornado":
            raise
        raise InputError(_EXTRA) from None
    from hunav_drake.editor.worker import Worker

    if options.out is not None:
        from hunav_drake.commands.errors import check_out

        check_out(options.out)
    imports = tuple(getattr(options, "imports", ()))
    with contextlib.ExitStack() as stack:
        worker = Worker(imports=imports, out=options.out)
        stack.callback(worker.close)
        session = _session(options, imports, worker)
        stack.callback(session.close)
        is_dirty = [False]
        session.subscribe(
            lambda it: (
                is_dirty.append(it["dirty"]) if it["kind"] == "state" else None
            )
        )
        with input_errors(place=f"--port {options.port}"):
            page = EditPage(session, port=options.port, find_file=worker.file)

        def ready() -> None:
            print(f"Editing {options.file or 'a new scenario'} at", flush=True)
            print(f"  {page.url}", flush=True)
            print("Ctrl-C ends it.", flush=True)
            if not options.no_browser:
                import webbrowser

                webbrowser.open(page.url)
            worker.start()

        with contextlib.suppress(KeyboardInterrupt):
            page.run(ready)
        if is_dirty[-1]:
            print("The browser keeps the unsaved changes.")
    return DONE


def _session(
    options: argparse.Namespace, imports: tuple[str, ...], worker: Any
) -> Any:
    """Returns a session on the file or template of the options."""
    from hunav_drake.editor.session import EditSession
    from hunav_drake.scenario.templates import template_text
    from hunav_drake.scenarios import shipped_names, shipped_text
    from hunav_drake.systems.common.suggest import suggestion

    text = None
    filename = None if options.file is None else Path(options.file)
    if filename is not None and options.template is not None:
        raise InputError(
            "give a file or --template; the file is chosen when it is saved"
        )
    with input_errors(ValueError):
        if options.template is not None:
            text = template_text(options.template)
        elif filename is not None and not filename.exists():
            if options.file in shipped_names():
                filename, text = None, shipped_text(options.file)
            elif filename.suffix not in (".yaml", ".yml"):
                names = shipped_names()
                raise InputError(
                    f"there is no file or shipped scenario {options.file!r};"
                    f" {suggestion(options.file, names)}; the name of a new"
                    " file ends in .yaml"
                )
        session = EditSession(
            text,
            filename=filename,
            imports=imports,
            worker=worker,
            scenario_name=options.name,
        )
        if options.map is not None:
            session.set_map(options.map)
    return session
