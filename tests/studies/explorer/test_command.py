"""The command: what it refuses before it serves anything."""

import socket
import sys

from studies.explorer.serve import ADDRESS


def test_missing_extra_is_named(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    answer = run("explore", "atlantiksolar-as2", "--no-browser")
    assert answer.code == 2
    assert "pip install 'solar-uav-sizing[explore]'" in answer.err
    assert answer.out == ""


def test_taken_port_is_told(run):
    with socket.socket() as taken:
        taken.bind((ADDRESS, 0))
        taken.listen()
        port = taken.getsockname()[1]
        answer = run("explore", "atlantiksolar-as2", "--no-browser", "--port", str(port))
    assert answer.code == 1
    assert f"cannot listen on {ADDRESS}:{port}" in answer.err
    assert answer.out == ""
