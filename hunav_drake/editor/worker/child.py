"""The main function of a process of the worker."""

from collections.abc import Callable, Sequence
import contextlib
import contextvars
import logging
from multiprocessing.connection import Connection
import os
import sys
import threading
import time

from hunav_drake.editor.worker.channel import Channel, Stopped, answer

# The process has a low priority, so that the machine stays responsive.
_NICE = 5

# The period at which it looks for questions while it compiles, in seconds.
_LOOK_TIME = 0.05

_COMPILING = (
    "Preparing the simulation. The first time on a machine it is compiled,"
    " which takes about a minute. Everything except Run works already."
)


def main(descriptor: int, imports: Sequence[str]) -> None:
    """Works until the parent ends it.

    Args:
        descriptor: The file descriptor of the pipe.
        imports: Modules of users to import.
    """
    with contextlib.suppress(OSError):
        os.nice(_NICE)
    watch = threading.Thread(target=_end_with, args=[os.getppid()], daemon=True)
    watch.start()
    channel = Channel(Connection(descriptor))
    _import(imports)
    from hunav_drake.editor.worker.catalog import make_catalog
    from hunav_drake.editor.worker.trials import Trials
    from hunav_drake.systems.common.choice_loading import registered_only

    logging.getLogger("drake").setLevel(logging.WARNING)
    # Scenarios can only use code that was imported above.
    with registered_only():
        channel.send(make_catalog())
        channel.send(
            {"kind": "worker", "status": "starting", "message": _COMPILING}
        )
        trials = Trials(channel)
        answer_during(trials.warm_up, channel)
        channel.send({"kind": "worker", "status": "ready", "message": ""})
        while True:
            message = channel.next()
            match message["do"]:
                case "end":
                    # At once: there is nothing to clean up.
                    os._exit(0)
                case "run":
                    trials.run(message)
                case "check" | "summary":
                    answer(channel, message)


def answer_during(work: Callable[[], object], channel: Channel) -> None:
    """Does some work in a thread, and answers questions at the same time.

    Raises:
        Exception: The exception of the work.
    """
    failures: list[BaseException] = []

    def do() -> None:
        try:
            work()
        except BaseException as error:
            failures.append(error)

    context = contextvars.copy_context()
    thread = threading.Thread(target=context.run, args=[do], daemon=True)
    thread.start()
    while thread.is_alive():
        try:
            channel.look()
        except Stopped:
            os._exit(0)
        thread.join(_LOOK_TIME)
    if failures:
        raise failures[0]


def _end_with(parent: int) -> None:
    """Ends the process with its parent, also while modules are loaded."""
    while os.getppid() == parent:
        time.sleep(1.0)
    os._exit(0)


def _import(names: Sequence[str]) -> None:
    """Imports modules of users; prints an error, and exits."""
    if not names:
        return
    from hunav_drake.systems.common.input_error import InputError
    from hunav_drake.trial.user_code import import_user_code

    try:
        import_user_code(names)
    except InputError as error:
        print(error, flush=True)
        sys.exit(1)
