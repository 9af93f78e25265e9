"""Who may see the editor, and what a scenario may do to it."""

from http.client import HTTPConnection
from importlib.resources import files
import re

import pytest

from tests.browser.driver import PATIENCE, SMALL, serve

pytest.importorskip("tornado", reason="the extra `editor` is not here")


@pytest.fixture
def server(tmp_path):
    (tmp_path / "secret.txt").write_text("secret")
    started = serve(folder=tmp_path)
    yield started
    started.stop()


def get(server, path, *, host=None, cookie=None, **headers):
    """Asks a server for a path; returns the answer, with its text."""
    port = server.page.port
    connection = HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
    headers["Host"] = host or f"127.0.0.1:{port}"
    if cookie is not None:
        headers["Cookie"] = cookie
    headers = {key.replace("_", "-"): value for key, value in headers.items()}
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    answer.content = answer.read()
    answer.text = answer.content.decode(errors="replace")
    connection.close()
    return answer


def enter(server):
    """Returns the cookie that the token is exchanged for."""
    answer = get(server, f"/?token={server.page.token}")
    assert answer.status == 302
    assert answer.headers["Location"] == "/"
    cookie = answer.headers["Set-Cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie
    return cookie.split(";")[0]


def handshake(server, **headers):
    return get(
        server,
        "/socket",
        Upgrade="websocket",
        Connection="Upgrade",
        Sec_WebSocket_Key="dGhlIHNhbXBsZSBub25jZQ==",
        Sec_WebSocket_Version="13",
        **headers,
    ).status


def test_only_the_token_lets_in(server):
    assert get(server, "/").status == 403
    assert get(server, "/?token=").status == 403
    assert get(server, f"/?token={server.page.token[:-1]}x").status == 403
    assert get(server, "/editor.js").status == 403
    cookie = enter(server)
    assert get(server, "/", cookie=cookie).status == 200
    assert get(server, "/editor.js", cookie=cookie).status == 200
    assert get(server, "/", cookie=cookie + "x").status == 403


def test_the_token_has_256_bits_and_changes(server, tmp_path):
    other = serve(folder=tmp_path)
    try:
        assert len(server.page.token) >= 43
        assert other.page.token != server.page.token
        assert other.page.cookie != server.page.cookie
    finally:
        other.stop()


def test_another_host_is_refused(server):
    cookie = enter(server)
    port = server.page.port
    assert (
        get(server, "/", cookie=cookie, host=f"localhost:{port}").status == 200
    )
    for host in (
        "evil.example",
        f"evil.example:{port}",
        "127.0.0.1",
        f"127.0.0.2:{port}",
    ):
        assert get(server, "/", cookie=cookie, host=host).status == 403
        assert (
            get(server, f"/?token={server.page.token}", host=host).status == 403
        )


def test_a_socket_needs_cookie_and_exact_origin(server):
    cookie = enter(server)
    own = f"http://127.0.0.1:{server.page.port}"
    assert handshake(server, Origin=own) == 403
    assert handshake(server, cookie=cookie) == 403
    for origin in (
        "null",
        "http://evil.example",
        own + "0",
        own.replace("http:", "https:"),
        own.replace("127.0.0.1", "localhost"),
    ):
        assert handshake(server, cookie=cookie, Origin=origin) == 403


def test_nothing_outside_the_list_is_served(server):
    cookie = enter(server)
    for path in (
        "/../pyproject.toml",
        "/%2e%2e/page.py",
        "/page.py",
        "/static/editor.js",
        "/secret.txt",
        "/results/a/b/report.html",
        "/results/../../secret.txt",
        "//etc/passwd",
    ):
        answer = get(server, path, cookie=cookie)
        assert answer.status == 404
        assert "secret" not in answer.text


def test_the_front_end_is_small(server):
    cookie = enter(server)
    size = 0
    for name, content in server.page.static.items():
        answer = get(server, f"/{name}", cookie=cookie, Accept_Encoding="gzip")
        size += len(answer.content)
        assert len(content.splitlines()) < 300, name
    print(f"{size / 1000:.0f} kB are sent")
    assert size < 120_000


def test_pages_have_a_strict_policy(server):
    cookie = enter(server)
    for path in ("/", "/editor.js", "/nothing"):
        headers = get(server, path, cookie=cookie).headers
        policy = headers["Content-Security-Policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert "frame-ancestors 'none'" in policy
        assert headers["X-Content-Type-Options"] == "nosniff"
        assert headers["Referrer-Policy"] == "no-referrer"
        assert "Access-Control-Allow-Origin" not in headers


def test_results_have_no_origin_and_no_editor(tmp_path):
    report = tmp_path / "report.html"
    report.write_text("<p>done</p>")
    wanted = ("t", "1", "report.html")
    server = serve(
        folder=tmp_path,
        find_file=lambda *asked: report if asked == wanted else None,
    )
    try:
        answer = get(server, "/results/t/1/report.html")
        assert answer.status == 200
        policy = answer.headers["Content-Security-Policy"]
        assert policy.startswith("sandbox allow-scripts")
        assert "allow-same-origin" not in policy
        assert get(server, "/results/t/2/report.html").status == 404
        assert get(server, "/results/t/1/secret.txt").status == 404
        host = "evil.example"
        assert get(server, "/results/t/1/report.html", host=host).status == 403
    finally:
        server.stop()


def test_files_outside_the_folder_are_refused(server, tmp_path):
    told = []
    server.session.subscribe(told.append)
    for name in ("../x.yaml", "/etc/passwd", "a/../../x.yaml"):
        server.session.receive({"do": "save", "filename": name, "id": 1})
        assert told[-1]["kind"] == "error"
        server.session.receive({"do": "open", "filename": name, "id": 2})
        assert told[-1]["kind"] == "error"
    assert not (tmp_path.parent / "x.yaml").exists()


def test_the_page_makes_no_html_of_texts():
    static = files("hunav_drake.editor") / "static"
    risky = re.compile(
        r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\b"
        r"|new Function|setTimeout\(\s*[\"'`]|javascript:"
    )
    for item in static.iterdir():
        if item.name.endswith((".js", ".html")):
            found = risky.search(item.read_text())
            assert found is None, f"{item.name}: {found}"


@pytest.mark.slow
def test_a_name_of_html_is_text(open_editor):
    name = "<img src=x onerror=window.hacked=1>"
    editor = open_editor(SMALL.replace("name: alba", f'name: "{name}"'))
    editor.click(-3, 0)
    editor.tab("problems")
    row = editor.page.locator(".row-item .row-name").first
    editor.expect(row).to_have_text(name)
    editor.expect(editor.page.locator(".panel-title").first).to_have_text(name)
    editor.expect(editor.page.locator("img")).to_have_count(0)
    assert editor.page.evaluate("window.hacked") is None
