import numpy as np

from hunav_drake.editor.session import EditSession
from tests.hunav_drake.editor.test_session import View


class Helper:
    """A worker that knows one model; it answers when it is told to."""

    def __init__(self):
        self.tickets = 0

    def listen(self, callback):
        self.tell = callback

    def check(self, text, folder, name):
        self.tickets += 1
        return self.tickets

    def repeat(self):
        pass

    def answer(self):
        square = [[1, 0], [2, 0], [2, 1], [1, 1]]
        models = {"rack.sdf": [square]}
        answer = {"ticket": self.tickets, "faults": [], "models": models}
        self.tell({"kind": "checked", **answer})


def test_models_stand_where_their_pose_is():
    worker = Helper()
    text = "world:\n  models: [{file: rack.sdf, pose: [10, 0, 1.5707963]}]\n"
    view = View(EditSession(text, worker=worker))
    worker.answer()
    outline = told_outlines(view)["world/models/0"]
    corners = np.array([[10, 1], [10, 2], [9, 2], [9, 1]])
    assert np.allclose(outline["points"], corners, atol=1e-3)
    # Where it is moved, it is at once; the worker is not needed for that.
    view.edit(["set", ["world", "models", 0, "pose"], [0, 0, 0]])
    assert told_outlines(view)["world/models/0"]["points"][0] == [1, 0]


def told_outlines(view):
    """Returns the outlines that the view was told last."""
    return [it["outlines"] for it in view.messages if it.get("outlines")][-1]
