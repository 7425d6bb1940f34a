"""The live page answers its own user and nobody else."""

import socket
from http.client import HTTPConnection
from urllib.parse import urlsplit

import pytest

from tests.patience import PATIENCE_S
from wheelhop.logger import live
from wheelhop.logger.live import Live, LivePlot


@pytest.fixture
def plot():
    with LivePlot(Live()) as plot:
        yield plot


def get(plot, path=None, **headers):
    url = urlsplit(plot.url)
    connection = HTTPConnection(url.hostname, url.port, timeout=PATIENCE_S)
    connection.request("GET", url.path if path is None else path, headers=headers)
    return connection.getresponse()


def test_the_page_and_its_stream_come_to_who_has_the_address(plot):
    page = get(plot)
    assert page.status == 200 and b"EventSource" in page.read()
    policy = page.headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy and "frame-ancestors 'none'" in policy
    assert page.headers["X-Content-Type-Options"] == "nosniff"
    stream = get(plot, urlsplit(plot.url).path + "events")
    assert stream.status == 200 and stream.readline().startswith(b"data: {")


@pytest.mark.parametrize("path", ["/", "/events", "/0000000000000000000000/", "//", "/../"])
def test_nothing_comes_without_the_token(plot, path):
    assert get(plot, path).status == 404


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "rebound.example"},
        {"Host": "localhost"},
        {"Origin": "http://elsewhere.example"},
        {"Origin": "null"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
    ],
)
def test_nothing_comes_to_another_page(plot, headers):
    assert get(plot, **headers).status == 403


def test_every_page_has_a_token_of_its_own():
    with LivePlot(Live()) as one, LivePlot(Live()) as two:
        assert urlsplit(one.url).path != urlsplit(two.url).path
        assert len(urlsplit(one.url).path) > 20


def test_streams_and_connections_are_few_and_do_not_wait_for_ever(monkeypatch):
    monkeypatch.setattr(live, "MOST_STREAMS", 2)
    monkeypatch.setattr(live, "MOST_CONNECTIONS", 6)
    monkeypatch.setattr(live._Handler, "timeout", 0.5)
    with LivePlot(Live()) as plot:
        url = urlsplit(plot.url)
        streams = [get(plot, url.path + "events") for _ in range(3)]
        assert [stream.status for stream in streams] == [200, 200, 503]
        idle = [socket.create_connection((url.hostname, url.port), 5) for _ in range(6)]
        assert idle[-1].recv(1) == b""  # refused at once
        for connection in idle:  # after half a second without a request
            assert connection.recv(1) == b""
        assert get(plot).status == 200
        for connection in idle:
            connection.close()
