"""The live page: what it shows, whom it answers, and a real drag in a real browser."""

import contextlib
import json
import math
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from http.client import HTTPConnection
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import Browser, browser_or_skip

import ecm_fast as ecm
from ecm_fast.errors import InputError
from ecm_fast.mechanism.catalogue import CATALOGUE
from ecm_fast.pages.live import Page, Scene
from ecm_fast.pages.live.controls import LAM_MAX, controls
from ecm_fast.pages.live.drawing import outline
from ecm_fast.pages.live.scene import parsed

pytestmark = pytest.mark.slow

NECK = ecm.Mechanism()


# what is shown


def test_every_effect_and_load_has_a_slider() -> None:
    """Contract: one slider a number, at the mechanism's value."""
    neck = NECK.replace(precurvature=2.0, EI=1.5)
    sliders = {control.name: control for control in controls(neck)}
    assert {"lam_l", "lam_r", "fx", "fz", "tau", "beam.EI", "tendons.plate_half_width"} <= set(sliders)
    assert {entry.key for effect in CATALOGUE.values() for entry in effect} <= set(sliders)
    assert (sliders["beam.EI"].value, sliders["effects.precurvature"].value) == (1.5, 2.0)
    for control in sliders.values():
        assert control.low <= control.value <= control.high
        assert control.low < control.high
        if "." in control.name:  # both ends are values that a mechanism may have
            neck.replace(**{control.name: control.low}).replace(**{control.name: control.high})


def test_a_frame_is_the_solve_of_its_inputs() -> None:
    """Another way in: `solve` of the same mechanism and loads."""
    scene = Scene(NECK)
    inputs = {"lam_l": 80.0, "lam_r": 15.0, "fz": -4.0, "tau": 0.2, "beam.EI": 2.5, "effects.precurvature": 1.0}
    frame = scene.frame({"id": 7, "inputs": inputs})
    neck = NECK.replace(EI=2.5, precurvature=1.0)
    eq = ecm.FiniteElementModel(neck, 20, 3).solve((80.0, 15.0), (0.0, -4.0, 0.2))
    assert (frame["id"], frame["stable"], frame["lam"]) == (7, True, [80.0, 15.0])
    assert frame["pose"] == pytest.approx(eq.pose, abs=2e-6)
    beam = np.array(frame["outline"]["beam"])
    assert beam == pytest.approx(eq.shape(len(beam)), abs=1e-5)
    assert 0.0 < frame["polynomial"]["mm"] < 1.0
    assert 0.0 < frame["step_us"] < frame["solve_us"] < frame["frame_us"]
    cloud = np.array(frame["workspace"])
    corner = ecm.FiniteElementModel(neck).solve((LAM_MAX, 0.0), (0.0, -4.0, 0.2))
    assert np.abs(cloud - corner.pose[:2]).sum(axis=1).min() < 1e-5
    assert "workspace" not in scene.frame({"id": 8, "inputs": {**inputs, "lam_l": 10.0}})
    assert "workspace" in scene.frame({"id": 9, "inputs": {**inputs, "fz": 1.0}})


def test_a_case_without_equilibrium_is_said_in_words() -> None:
    """Contract: null pose, a message, strict JSON."""
    frame = Scene(NECK).frame({"id": 0, "inputs": {"lam_l": 9000.0}})
    assert (frame["pose"], frame["outline"], frame["stable"]) == (None, None, False)
    assert "equilibrium" in frame["message"]
    json.dumps(frame, allow_nan=False)


def test_the_lines_meet_where_the_parts_meet() -> None:
    """Geometry by hand: plate ends, tangent points, center of mass."""
    neck = NECK.replace(pulley_z=0.06, pulley_radius=0.008, pulley_x=-0.01, b=0.004)
    eq = ecm.FiniteElementModel(neck).solve((100.0, 0.0))
    lines = outline(neck, eq)
    head = np.array([[math.cos(eq.theta), -math.sin(eq.theta)], [math.sin(eq.theta), math.cos(eq.theta)]])
    for side, end, tendon, center in zip((1, -1), lines["plate"], lines["tendons"], lines["pulleys"], strict=True):
        assert end == pytest.approx(eq.pose[:2] + side * 0.07 * head[1], abs=1e-6)
        arm, rope = np.array(tendon[1]) - center, np.array(tendon[0]) - tendon[1]
        assert np.linalg.norm(arm) == pytest.approx(0.008, abs=2e-6)
        assert abs(arm @ rope) < 1e-6  # a tangent
        assert side * arm[1] > 0.0  # on the outer side
    assert lines["mass"] == pytest.approx(eq.pose[:2] + 0.05 * head[0] + 0.004 * head[1], abs=1e-6)


def test_the_head_goes_where_it_is_dragged_or_as_near_as_it_can() -> None:
    """Round trip: the pose of known forces; beyond it, the nearest by brute force."""
    scene, model = Scene(NECK), ecm.FiniteElementModel(NECK)
    goal = model.solve((90.0, 35.0)).pose[:2]
    frame = scene.frame({"id": 1, "inputs": {"lam_l": 0.0, "lam_r": 0.0}, "wish": goal.tolist()})
    assert frame["pose"][:2] == pytest.approx(goal, abs=2e-6)
    assert frame["lam"] == pytest.approx([90.0, 35.0], abs=0.01)
    side = np.linspace(0.0, LAM_MAX, 321)
    grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    for wish in ([0.12, 0.01], [0.09, -0.03], [0.109, 0.5]):
        frame = scene.frame({"id": 2, "inputs": {"lam_l": 20.0, "lam_r": 60.0}, "wish": wish})
        distances = np.hypot(*(model.solve_batch(grid).pose[:, :2] - wish).T)
        assert np.hypot(*(np.array(frame["pose"][:2]) - wish)) <= distances.min() + 2e-5
        assert all(0.0 <= force <= LAM_MAX for force in frame["lam"])


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "'' is no JSON"),
        ("[1, 2]", "[1, 2]: allowed is an object with id, inputs, wish"),
        ('{"id": 1, "run": "rm"}', "{'id': 1, 'run': 'rm'}: allowed is an object"),
        ('{"inputs": {}}', "id = None: allowed is a whole number"),
        ('{"id": true}', "id = True: allowed is a whole number"),
        ('{"id": 1e400}', "id = inf: allowed is a whole number"),
        ('{"id": 1, "inputs": {"lam_l": NaN}}', "is no JSON"),
        ('{"id": 1, "inputs": {"lam_l": 1e999}}', "lam_l = inf: allowed is a number >= 0"),
        ('{"id": 1, "inputs": {"lam_l": -1}}', "lam_l = -1: allowed is a number >= 0"),
        ('{"id": 1, "inputs": {"lam_l": "40"}}', "lam_l = '40': allowed is a number >= 0"),
        ('{"id": 1, "inputs": {"fx": 1e300}}', "fx = 1e+300: allowed is a number of at most 1e6"),
        ('{"id": 1, "inputs": [3]}', "inputs = [3]: allowed is an object of numbers by name"),
        ('{"id": 1, "inputs": {"beam.EI": -3}}', "beam.EI = -3: allowed is a finite number from 1e-12"),
        ('{"id": 1, "inputs": {"beam.EL": 3}}', "no input is called 'beam.EL' (did you mean 'beam.E"),
        ('{"id": 1, "inputs": {"beam.axial_law": 1}}', "no input is called 'beam.axial_law'"),
        ('{"id": 1, "wish": [1]}', "wish = [1]: allowed is a place [x, z] in metres"),
        ('{"id": 1, "wish": [1, 1e9]}', "wish = [1, 1000000000.0]: allowed is a place"),
        ("[" * 60000, "is no JSON"),
        ('{"id": ' + "1" * 5000 + "}", "is no JSON"),
        (b"\0\xff", "a request is text, not bytes"),
    ],
)
def test_a_hostile_request_is_refused_in_one_line(text: str | bytes, complaint: str) -> None:
    """Contract: the text of the error."""
    with pytest.raises(InputError) as caught:
        Scene(NECK).frame(parsed(text))
    assert complaint in str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


# who is answered


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    pytest.importorskip("websockets", reason="no page here: websockets is not installed")
    file = tmp_path_factory.mktemp("data") / "run.csv"
    file.write_text("lam_l_N,lam_r_N,x_mm,z_mm,theta_rad\n40,0,108,5,-0.1\n40,10,107,,-0.1\n")
    data = ecm.read_measurements(file)
    with Page(lambda: Scene(NECK, data)) as running:
        thread = threading.Thread(target=running.serve)
        thread.start()
        yield running
        running.stop()
        thread.join(10)
        assert not thread.is_alive()


def connect(page: Page, **options: Any) -> Any:
    from websockets.sync.client import connect

    origin = options.pop("origin", page.url.rstrip("/"))
    return connect(f"ws://127.0.0.1:{page.port}/socket", origin=origin, max_size=None, proxy=None, **options)


def test_the_files_come_with_a_policy_against_other_hosts(page: Page) -> None:
    """Contract: the headers of the reply."""
    for path, kind in (("", "text/html"), ("page.js", "text/javascript"), ("page.css", "text/css")):
        with urllib.request.urlopen(page.url + path, timeout=10) as reply:
            assert reply.headers["Content-Type"] == f"{kind}; charset=utf-8"
            assert reply.headers["Content-Security-Policy"].startswith("default-src 'self';")
            assert re.findall(r"https?:|src=\"(?!/)|@import", reply.read().decode()) == []
    with pytest.raises(urllib.error.HTTPError) as caught:
        urllib.request.urlopen(page.url + "../server.py", timeout=10)
    assert caught.value.code == 404
    caught.value.close()


@pytest.mark.parametrize(
    ("path", "headers"),
    [
        ("/", {"Host": "evil.example"}),
        ("/", {"Host": "evil.example:80", "Origin": "http://evil.example:80"}),
        ("/socket", {"Origin": "http://evil.example"}),
        ("/socket", {"Origin": "null"}),
        ("/socket", {}),
    ],
)
def test_another_name_or_origin_is_refused(page: Page, path: str, headers: dict[str, str]) -> None:
    """Contract: HTTP status 403."""
    upgrade = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13"}
    connection = HTTPConnection("127.0.0.1", page.port, timeout=10)
    connection.request("GET", path, headers={**upgrade, "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==", **headers})
    reply = connection.getresponse()
    assert reply.status == 403
    reply.read()
    connection.close()


def test_a_page_is_greeted_and_answered(page: Page) -> None:
    """Contract: the messages of a real socket."""
    with connect(page) as socket:
        hello = json.loads(socket.recv(10))
        assert {control["name"] for control in hello["controls"]} >= {"lam_l", "beam.EI"}
        assert hello["measured"] == [[0.108, 0.005, -0.1]]
        socket.send(json.dumps({"id": 3, "inputs": {"lam_l": 30.0}}))
        frame = json.loads(socket.recv(10))
        assert (frame["id"], frame["stable"]) == (3, True)


def test_hostile_messages_are_answered_and_the_page_lives_on(page: Page) -> None:
    """Contract: an error for each, then a good answer."""
    with connect(page) as socket:
        socket.recv(10)
        for text in (
            "{",
            "[]",
            b"\0\1",
            '{"id": 1, "inputs": {"lam_l": -1}}',
            '{"id": 2, "inputs": {"x": {}}}',
            "[" * 9999,
        ):
            socket.send(text)
            assert json.loads(socket.recv(10))["error"]
        socket.send('{"id": 4}')
        assert json.loads(socket.recv(10))["id"] == 4
    from websockets.exceptions import ConnectionClosed

    with connect(page) as socket:
        socket.recv(10)
        socket.send("x" * 100_000)
        with pytest.raises(ConnectionClosed):
            socket.recv(10)
    with connect(page) as socket:
        assert "controls" in json.loads(socket.recv(10))


def test_idle_connections_are_capped_and_the_reason_is_said(tmp_path: Path) -> None:
    """POSIX: with 256 descriptors 500 clients that say nothing end a server that takes them all."""
    pytest.importorskip("websockets", reason="no page here: websockets is not installed")
    resource = pytest.importorskip("resource", reason="limits of POSIX")
    code = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_NOFILE, (256, 256)); "
        "from ecm_fast.cli import main; sys.exit(main(['view', '--no-browser']))"
    )
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(2048, before[1]), before[1]))
    process = subprocess.Popen([sys.executable, "-c", code], stderr=subprocess.PIPE, text=True, cwd=tmp_path)
    try:
        assert process.stderr is not None
        url = process.stderr.readline().split()[1]
        port = int(url.rstrip("/").rpartition(":")[2])
        idle = [socket.create_connection(("127.0.0.1", port), timeout=20) for _ in range(500)]
        answered = []
        for client in idle:
            client.settimeout(0.2)
            with contextlib.suppress(OSError):
                answered.append(client.recv(1000))
        assert sum(b"connections are open, and no more" in answer for answer in answered) > 400
        for client in idle:
            client.close()
        deadline = time.monotonic() + 30.0
        while time.monotonic() < deadline:
            try:
                page = urllib.request.urlopen(url, timeout=10).read()
                break
            except (urllib.error.URLError, ConnectionError):
                time.sleep(0.2)
        assert page.startswith(b"<!DOCTYPE html>")
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=60) == 0
    finally:
        process.kill()
        process.communicate()
        resource.setrlimit(resource.RLIMIT_NOFILE, before)


def test_of_many_requests_the_newest_is_answered(page: Page) -> None:
    """Contract: the last answer is that of the last request."""
    with connect(page) as socket:
        socket.recv(10)
        for number in range(1, 301):
            socket.send(json.dumps({"id": number, "inputs": {"lam_l": number / 10.0}}))
        answers = []
        while not answers or answers[-1] < 300:
            answers.append(json.loads(socket.recv(10))["id"])
        assert answers == sorted(answers)
        assert len(answers) < 300


def test_the_command_ends_cleanly_when_it_is_interrupted(tmp_path: Path) -> None:
    """Contract: a real interrupt, exit code and output."""
    pytest.importorskip("websockets", reason="no page here: websockets is not installed")
    words = [sys.executable, "-m", "ecm_fast", "view", "--no-browser", "--json"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path)
    assert process.stderr is not None
    url = process.stderr.readline().split()[1]
    assert urllib.request.urlopen(url, timeout=10).read().startswith(b"<!DOCTYPE html>")
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (0, "")
    assert json.loads(out) == {"url": url, "frames": 0}


def test_a_port_that_is_taken(page: Page) -> None:
    """The operating system's reason in one line."""
    with pytest.raises(InputError, match=rf"^--port {page.port}: cannot be listened on \(Address already in use\)$"):
        Page(lambda: Scene(NECK), page.port)


# a browser


@pytest.fixture(scope="module")
def browser(page: Page, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser_or_skip(tmp_path_factory.mktemp("browser")) as running:
        yield running


def opened(browser: Browser, page: Page, width: int = 1100, height: int = 800) -> None:
    browser.open(page.url, width, height)
    browser.wait("window.view && view.drawn > 0")


def middle(browser: Browser, name: str) -> tuple[float, float]:
    box = browser.value(f"(() => {{ const b = document.querySelector('{name}').getBoundingClientRect();"
                        "return [b.x + b.width / 2, b.y + b.height / 2]; })()")  # fmt: skip
    return box[0], box[1]


RECORD = """(() => {
  window.seen = [];
  const look = (now) => { seen.push([now, view.sent, view.received, view.drawn]); requestAnimationFrame(look); };
  requestAnimationFrame(look);
})()"""


def test_a_drag_of_the_head_shows_the_newest_pose_in_every_frame(browser: Browser, page: Page) -> None:
    """A real browser: every drawn frame is the newest solved one."""
    opened(browser, page)
    x, y = middle(browser, "#head")
    browser.value(RECORD)
    browser.mouse("mousePressed", x, y)
    seconds = float(os.environ.get("ECM_FAST_DRAG_SECONDS", "1"))
    start, moves = time.monotonic(), 0
    while (now := time.monotonic() - start) < seconds:
        browser.mouse("mouseMoved", x + 60.0 * math.sin(3.0 * now), y + 5.0 * math.cos(5.0 * now))
        moves += 1
    browser.mouse("mouseReleased", x, y)
    browser.wait("view.drawn === view.sent")
    seen = np.array(browser.value("seen"))
    frames = browser.value("view.frameUs")
    assert len(seen) > 5
    assert np.array_equal(seen[:, 3], seen[:, 2])  # drawn is the newest received
    assert (seen[:, 1] - seen[:, 3]).max() <= 1  # and no more than one is under way
    assert seen[-1, 3] > seen[0, 3] + 3
    if "ECM_FAST_DRAG_SECONDS" in os.environ:  # to measure by hand: pytest -s
        drawn = len(np.unique(seen[:, 3]))
        print(f"\n{moves} moves, {len(seen) / np.ptp(seen[:, 0]) * 1e3:.1f} frames/s, {drawn} poses, "
              f"server {np.median(frames):.0f} us a frame")  # fmt: skip
    assert browser.complaints == []


def test_keys_move_sliders_head_and_load(browser: Browser, page: Page) -> None:
    """A real browser: arrow keys change what they should."""
    opened(browser, page)
    before = browser.value("view.frame.pose")
    browser.value("document.querySelector('#head').focus()")
    browser.key("ArrowLeft")
    browser.wait(f"view.frame.pose[1] > {before[1] + 0.0009}")
    browser.value("document.querySelector('#load').focus()")
    browser.key("ArrowRight")
    browser.wait("sliders.get('fz').value === -1 && view.drawn === view.sent")
    browser.value("document.querySelector('input[name=lam_r]').focus()")
    force = browser.value("view.frame.lam[1]")
    browser.key("ArrowRight")
    browser.wait(f"view.frame.lam[1] > {force} + 0.1")
    browser.value("document.querySelector('#reset').click()")
    browser.wait("view.drawn === view.sent && view.frame.lam[0] === 40")
    assert browser.complaints == []


def test_a_small_screen_shows_all_of_it_below_each_other(browser: Browser, page: Page) -> None:
    """A real browser: the layout at 360 by 640."""
    opened(browser, page, 360, 640)
    assert browser.value("document.documentElement.scrollWidth") <= 360
    stage, panel = (browser.value(f"document.querySelector('{name}').getBoundingClientRect().top")
                    for name in ("#stage", "#panel"))  # fmt: skip
    assert stage < panel
    picture = browser.picture()
    if "ECM_FAST_PICTURES" in os.environ:
        Path(os.environ["ECM_FAST_PICTURES"], "small.png").write_bytes(picture)
        opened(browser, page)
        Path(os.environ["ECM_FAST_PICTURES"], "view.png").write_bytes(browser.picture())
    assert browser.complaints == []
