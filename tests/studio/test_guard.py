"""Who gets in, and what is refused at the door."""

from __future__ import annotations

import http.client
import json

import pytest

from propermodel.studio.guard import MOST_BYTES
from tests.studio.client import Client

JSON = {"Content-Type": "application/json"}


def test_the_address_lets_in_and_leaves_a_cookie_that_scripts_cannot_read(studio: Client):
    answer = studio.ask("GET", f"/?token={studio.server.door.token}", headers={"Cookie": ""})
    assert (answer.status, answer.headers["location"]) == (303, "/")
    words = answer.headers["set-cookie"].lower()
    assert words.startswith(f"propermodel-{studio.server.door.port}=")
    assert all(word in words for word in ("httponly", "samesite=strict", "path=/"))
    assert studio.server.door.token not in answer.headers["location"]


@pytest.mark.parametrize("path", ["/", "/api/start", "/assets/studio.js", "/api/runs/1/signals", "/nowhere"])
@pytest.mark.parametrize(
    "cookie", ["", "propermodel-1=x", "propermodel-{port}=", "propermodel-{port}=wrong", "=;;;\xff"]
)
def test_without_the_token_nothing_is_told(studio: Client, path: str, cookie: str):
    answer = studio.ask("GET", path, headers={"Cookie": cookie.format(port=studio.server.door.port)})
    assert answer.status == 401
    assert answer.body.startswith(b"error[studio/token]")


@pytest.mark.parametrize("token", ["wrong", "", "%00", "%C3%A9"])
def test_a_wrong_token_lets_nobody_in(studio: Client, token: str):
    answer = studio.ask("GET", f"/?token={token}", headers={"Cookie": ""})
    assert answer.status == 401
    assert "set-cookie" not in answer.headers


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1", "localhost:1", "127.0.0.1.evil.example:{port}", "[::1]:{port}"]
)
def test_another_name_of_this_machine_is_refused(studio: Client, host: str):
    answer = studio.ask("GET", "/api/start", host=host.format(port=studio.server.door.port))
    assert (answer.status, answer.code) == (403, "studio/host")


def test_localhost_is_this_machine(studio: Client):
    assert studio.ask("GET", "/api/start", host=f"localhost:{studio.server.door.port}").status == 200


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "https://127.0.0.1:{port}", "http://127.0.0.1:1"])
@pytest.mark.parametrize("method", ["GET", "POST"])
def test_pages_of_others_are_refused(studio: Client, origin: str, method: str):
    headers = {**JSON, "Origin": origin.format(port=studio.server.door.port)}
    answer = studio.ask(method, "/api/trust", b"{}", headers)
    assert (answer.status, answer.code) == (403, "studio/origin")


def test_the_own_page_may_write(studio: Client):
    headers = {**JSON, "Origin": f"http://127.0.0.1:{studio.server.door.port}"}
    assert studio.ask("POST", "/api/trust", b"{}", headers).status == 200


@pytest.mark.parametrize("media", ["", "text/plain", "application/x-www-form-urlencoded", "multipart/form-data"])
def test_what_a_form_can_send_is_refused(studio: Client, media: str):
    answer = studio.ask("POST", "/api/runs", b'{"model": "half-car"}', {"Content-Type": media})
    assert (answer.status, answer.code) == (415, "studio/content-type")


def test_a_body_that_says_it_is_too_large_is_not_read(studio: Client):
    answer = studio.ask("POST", "/api/runs", None, {**JSON, "Content-Length": str(MOST_BYTES + 1)})
    assert (answer.status, answer.code) == (413, "studio/too-large")


def test_a_body_that_turns_out_too_large_is_refused(studio: Client):
    connection = http.client.HTTPConnection("127.0.0.1", studio.server.door.port, timeout=20)
    pieces = (b" " * 2**16 for _ in range(40))
    connection.request("POST", "/api/runs", pieces, {**JSON, "Cookie": studio.cookie}, encode_chunked=True)
    response = connection.getresponse()
    assert response.status == 413
    assert json.loads(response.read())["error"]["code"] == "studio/too-large"
    connection.close()


def test_pages_run_no_script_that_is_written_in_them(studio: Client):
    answer = studio.get("/")
    assert answer.status == 200
    policy = answer.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert b"<script>" not in answer.body
    for path in ("/", "/api/start", "/nowhere"):
        headers = studio.get(path).headers
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["referrer-policy"] == "no-referrer"


@pytest.mark.parametrize("path", ["/nowhere", "/api", "/api/nowhere", "/assets/../app.py", "/assets/..%2fapp.py", "//"])
def test_what_is_not_there_is_told_as_data(studio: Client, path: str):
    answer = studio.get(path)
    assert (answer.status, answer.code) == (404, "studio/page")


def test_another_method_is_refused(studio: Client):
    answer = studio.ask("PUT", "/api/start", b"{}", JSON)
    assert (answer.status, answer.code) == (405, "studio/page")
