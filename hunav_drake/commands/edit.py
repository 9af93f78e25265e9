"""The command `hunav edit`."""

import argparse
import contextlib
from pathlib import Path
from typing import Any

from hunav_drake.commands.errors import DONE, input_errors
from hunav_drake.commands.options import add_import_option
from hunav_drake.systems.common.input_error import InputError

_EXTRA = "hunav edit needs tornado: pip install 'hunav_drake[editor]'"


def add_edit_command(commands: Any) -> None:
    """Adds the command `hunav edit`."""
    edit = commands.add_parser(
        "edit",
        help="edit a scenario in the browser",
        description="Opens the editor of scenarios in the browser: a map on"
        " which people, goals, walls and the robot are placed, forms for"
        " everything else, and runs. It is served to this machine alone, until"
        " Ctrl-C, or half a minute after its last page was closed.",
    )
    edit.set_defaults(function=_edit)
    edit.add_argument(
        "file",
        nargs="?",
        help="a file, or the name of a shipped scenario; without one, the"
        " editor shows templates",
    )
    edit.add_argument(
        "--name", help="the scenario to edit, if the file holds several"
    )
    edit.add_argument(
        "--template",
        metavar="T",
        help="start with a template: corridor, crossing, office, cafe or room",
    )
    edit.add_argument(
        "--map",
        type=Path,
        metavar="M",
        help="lay a map of ROS 2's map_server (.yaml) or a picture under it",
    )
    edit.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="keep the results of runs in DIR; by default they are removed in"
        " the end",
    )
    edit.add_argument(
        "--port",
        type=_port,
        metavar="P",
        help="the port on 127.0.0.1; 0 for any that is free; by default"
        " always the same for a file, if it is free",
    )
    edit.add_argument(
        "--no-browser",
        action="store_true",
        help="print the address, but open no browser",
    )
    add_import_option(edit)


def _port(text: str) -> int:
    if not text.isdecimal() or int(text) > 65535:
        raise argparse.ArgumentTypeError(
            f"must be a whole number up to 65535, got {text!r}"
        )
    return int(text)


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
            print("What was not saved is kept by the browser.")
    return DONE


def _session(
    options: argparse.Namespace, imports: tuple[str, ...], worker: Any
) -> Any:
    """Returns a session on what the options name."""
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
