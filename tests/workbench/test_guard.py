"""Only the browser that was given the address is answered."""

import http.client
import shutil
import subprocess
import sys
from urllib.parse import urlsplit

import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from tests.patience import PATIENCE_S
from tests.workbench.conftest import workbench


@pytest.fixture(scope="module")
def address():
    with workbench() as (address, _):
        yield urlsplit(address)


def ask(address, path="/", method="GET", **headers):
    connection = http.client.HTTPConnection(address.hostname, address.port, timeout=PATIENCE_S)
    connection.putrequest(method, path, skip_host="Host" in headers)
    for key, value in headers.items():
        connection.putheader(key, value)
    connection.endheaders()
    answer = connection.getresponse()
    return answer.status, dict(answer.getheaders()), answer.read().decode("utf-8", "replace")


@pytest.fixture(scope="module")
def cookie(address):
    status, headers, _ = ask(address, f"/?{address.query}")
    assert status == 303
    assert headers["location"] == "/"
    assert "HttpOnly" in headers["set-cookie"] and "SameSite=Strict" in headers["set-cookie"]
    return headers["set-cookie"].split(";")[0]


def test_with_its_cookie_the_page_is_shown(address, cookie):
    status, headers, body = ask(address, Cookie=cookie)
    assert status == 200
    assert "wheelhop" in body
    policy = headers["content-security-policy"]
    assert "default-src 'self'" in policy and "frame-ancestors 'none'" in policy


def test_a_report_that_came_with_a_campaign_shows_and_does_nothing(tmp_path):
    folder = tmp_path / "campaign"
    shutil.copytree("examples/clean", folder)
    folder.chmod(0o755)
    (folder / "report.html").write_text("<script>alert(1)</script>")
    with workbench(folder) as (address, _):
        here = urlsplit(address)
        _, headers, _ = ask(here, f"/?{here.query}")
        token = headers["set-cookie"].split(";")[0]
        connection = http.client.HTTPConnection(here.hostname, here.port, timeout=PATIENCE_S)
        connection.request("GET", "/report", headers={"Cookie": token})
        answer = connection.getresponse()
        policies = answer.msg.get_all("content-security-policy")
    assert answer.status == 200
    assert any("sandbox" in policy and "script" not in policy for policy in policies)


def test_nothing_comes_from_elsewhere(address, cookie):
    _, _, body = ask(address, Cookie=cookie)
    assert "https://" not in body.replace("https://github.com", "")


@pytest.mark.parametrize(
    "path", ["/", "/_nicegui/", "/gallery/dry-friction.png", "/report", "/?token=guess"]
)
def test_without_the_token_nothing_is_said(address, path):
    status, _, body = ask(address, path)
    assert status == 403
    assert "token" in body
    assert "wheelhop-" not in body


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"},
        {"Host": "127.0.0.1"},
        {"Host": "127.0.0.1:1"},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
    ],
)
def test_other_names_and_other_pages_are_refused(address, cookie, headers):
    status, _, _ = ask(address, Cookie=cookie, **headers)
    assert status == 403


@pytest.mark.parametrize("value", ["wheelhop-0=x", "\x00\x01", "=;=;", "a" * 5000])
def test_a_cookie_of_nonsense_is_no_token(address, value):
    try:
        status, _, _ = ask(address, Cookie=value)
    except ValueError:  # http.client itself does not send it
        return
    assert status in (400, 403)


@pytest.mark.parametrize("path", ["/../session.toml", "/gallery/../worker.py", "/gallery/%2e%2e/x"])
def test_no_way_out_of_the_gallery(address, cookie, path):
    status, _, body = ask(address, path, Cookie=cookie)
    assert status in (400, 403, 404)
    assert "from __future__" not in body and "format = 1" not in body


def test_a_socket_of_another_page_is_closed(address, cookie):
    place = f"ws://{address.netloc}/_nicegui_ws/socket.io/?EIO=4&transport=websocket"
    for headers in ({"Cookie": cookie, "Origin": "http://evil.example"}, {}):
        with pytest.raises(InvalidStatus) as caught:
            connect(place, additional_headers=headers, open_timeout=PATIENCE_S).close()
        assert caught.value.response.status_code == 403


def test_a_folder_has_one_workbench(tmp_path):
    command = [sys.executable, "-m", "wheelhop.cli.main", "workbench", "--no-browser"]
    with workbench("examples/clean"):
        second = subprocess.run([*command, "examples/clean"], capture_output=True, text=True)
    assert second.returncode == 2
    assert "a workbench is open on it already" in second.stderr
    assert "Traceback" not in second.stderr


def test_no_campaign_and_a_port_that_is_taken_get_a_line(tmp_path, address):
    command = [sys.executable, "-m", "wheelhop.cli.main", "workbench", "--no-browser"]
    for arguments in ([tmp_path], ["--port", address.port]):
        done = subprocess.run(
            [*command, *map(str, arguments)], capture_output=True, text=True, timeout=PATIENCE_S
        )
        assert done.returncode == 2
        assert done.stderr.count("\n") == 1, done.stderr


def test_a_workbench_for_all_answers_by_any_address_and_no_stranger_s_name():
    """0.0.0.0 is what it listens on, and nobody's address."""
    with workbench("--host", "0.0.0.0") as (told, _):
        here = urlsplit(told)
        assert here.hostname != "0.0.0.0"
        local = urlsplit(f"http://127.0.0.1:{here.port}/?{here.query}")
        _, headers, _ = ask(local, f"/?{here.query}")
        token = headers["set-cookie"].split(";")[0]
        for name in (here.netloc, local.netloc, f"localhost:{here.port}"):
            status, _, _ = ask(local, Host=name, Origin=f"http://{name}", Cookie=token)
            assert status == 200, name
        for name in (f"evil.example:{here.port}", f"127.0.0.1:{here.port + 1}", "127.0.0.1"):
            assert ask(local, Host=name, Cookie=token)[0] == 403, name
        other = "http://192.0.2.7:80"
        assert ask(local, Host=local.netloc, Origin=other, Cookie=token)[0] == 403
