"""The server of the editor: what blocks it, and what stays open."""

import asyncio
import http.client
import json
import socket
import threading
import time

import pytest

from tests.browser.driver import PATIENCE, Server

pytest.importorskip("tornado", reason="the extra `editor` is not here")


class Session:
    """A session that is busy until it may end."""

    def __init__(self):
        self.received = []
        self.busy, self.free = threading.Event(), threading.Event()

    def subscribe(self, callback):
        return lambda: None

    def poll(self):
        self.received.append("poll")

    def receive(self, message):
        self.busy.set()
        assert self.free.wait(PATIENCE)
        self.received.append(message)

    def close(self):
        pass


@pytest.fixture
def session():
    return Session()


@pytest.fixture
def server(session):
    from hunav_drake.editor.page import EditPage

    started = Server(EditPage(session, port=0, idle=0.3), session)
    yield started
    session.free.set()
    started.stop()


def ask(connection, path, **headers):
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    answer.read()
    return answer


def test_what_takes_long_does_not_block_the_server(server, session):
    port = server.page.port
    connection = http.client.HTTPConnection("127.0.0.1", port, PATIENCE)
    answer = ask(connection, f"/?token={server.page.token}")
    cookie = answer.headers["Set-Cookie"].split(";")[0]
    for number in range(3):
        server.page.do(session.receive, number)
    assert session.busy.wait(PATIENCE)
    for _ in range(3):
        assert ask(connection, "/editor.js", Cookie=cookie).status == 200
    assert session.received == []
    session.free.set()
    end = time.monotonic() + PATIENCE
    while len(session.received) < 3 and time.monotonic() < end:
        time.sleep(0.01)
    assert session.received[:3] == [0, 1, 2]


@pytest.mark.parametrize(
    "sent",
    [
        b"",
        b"GET / HTTP/1.1\r\nHost: a",
        b"POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 100\r\n\r\nabc",
    ],
)
def test_a_connection_that_says_no_more_is_closed(server, sent):
    with socket.create_connection(("127.0.0.1", server.page.port)) as open_one:
        open_one.settimeout(PATIENCE)
        open_one.sendall(sent)
        while open_one.recv(1000):
            pass


def test_messages_are_read_and_done_in_the_thread_of_the_session(
    server, session
):
    """Through the channel, as pages send them."""
    from tornado.httpclient import HTTPRequest
    from tornado.websocket import websocket_connect

    port = server.page.port
    connection = http.client.HTTPConnection("127.0.0.1", port, PATIENCE)
    answer = ask(connection, f"/?token={server.page.token}")
    headers = {
        "Cookie": answer.headers["Set-Cookie"].split(";")[0],
        "Origin": f"http://127.0.0.1:{port}",
    }

    async def send():
        url = f"ws://127.0.0.1:{port}/socket"
        channel = await websocket_connect(HTTPRequest(url, headers=headers))
        await channel.write_message(json.dumps({"do": "hello"}))
        while not session.busy.is_set():
            await asyncio.sleep(0.01)
        assert ask(connection, "/editor.js", Cookie=headers["Cookie"])
        session.free.set()
        while {"do": "hello"} not in session.received:
            await asyncio.sleep(0.01)
        channel.close()

    asyncio.run(asyncio.wait_for(send(), PATIENCE))
