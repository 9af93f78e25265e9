"""What a process of the worker does besides runs."""

import json
from multiprocessing.connection import Pipe
import threading

import pytest

from hunav_drake.editor.worker.channel import Channel
from hunav_drake.editor.worker.child import answer_during

PATIENCE = 60.0


def test_names_are_checked_while_it_compiles():
    ours, theirs = Pipe()
    is_answered = threading.Event()
    answers = []

    def compile_all():
        # It ends only once the question was answered.
        assert is_answered.wait(PATIENCE)

    def ask():
        text = b'"humans: [{name: ana, behavior: curios}]"'
        ours.send_bytes(
            b'{"do": "check", "ticket": 3, "folder": null, "name": null,'
            b' "text": ' + text + b"}"
        )
        assert ours.poll(PATIENCE)
        answers.append(json.loads(ours.recv_bytes()))
        is_answered.set()

    asker = threading.Thread(target=ask, daemon=True)
    asker.start()
    answer_during(compile_all, Channel(theirs))
    asker.join(PATIENCE)
    (answer,) = answers
    assert (answer["kind"], answer["ticket"]) == ("checked", 3)
    paths = [it["path"] for it in answer["faults"]]
    assert ["humans", 0, "behavior"] in paths


def test_what_cannot_be_compiled_is_told():
    _, theirs = Pipe()

    def fail():
        raise RuntimeError("no compiler")

    with pytest.raises(RuntimeError, match="no compiler"):
        answer_during(fail, Channel(theirs))
