"""Chromium without a screen, driven through its debugging protocol: pages are drawn and asked what they show."""

from __future__ import annotations

import base64
import contextlib
import io
import itertools
import json
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    import numpy as np

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
OPTIONS = (
    "--headless=new", "--no-sandbox", "--hide-scrollbars", "--mute-audio", "--no-first-run", "--disable-dev-shm-usage",
    "--disable-extensions", "--disable-background-networking", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--remote-debugging-port=0", "--remote-allow-origins=*",
)  # fmt: skip


class Browser:
    """One page of a Chromium of its own.

    Args:
        executable: Path of Chromium.
        folder: Folder for its profile.
    """

    def __init__(self, executable: str, folder: Path) -> None:
        from websockets.sync.client import connect

        command = [executable, *OPTIONS, f"--user-data-dir={folder}", "about:blank"]
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            port_file = folder / "DevToolsActivePort"
            wait(lambda: port_file.exists() and len(port_file.read_text().splitlines()) > 1, 30, "Chromium to start")
            port, path = port_file.read_text().splitlines()[:2]
            self._socket = connect(f"ws://127.0.0.1:{port}{path}", max_size=None, compression=None)
        except BaseException:
            self.process.kill()
            self.process.wait()
            raise
        self._ids = itertools.count(1)
        self.messages: list[str] = []
        """Errors and warnings of the pages' console."""
        self._session = ""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.call(f"{domain}.enable")

    def close(self) -> None:
        """End the browser."""
        with contextlib.suppress(Exception):
            self._session = ""
            self.call("Browser.close")
        self._socket.close()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def call(self, method: str, **arguments: object) -> dict[str, Any]:
        """Send one command and return its result."""
        number = next(self._ids)
        session = {"sessionId": self._session} if self._session else {}
        self._socket.send(json.dumps({"id": number, "method": method, "params": arguments, **session}))
        while True:
            answer = json.loads(self._socket.recv(timeout=60))
            if answer.get("method") == "Runtime.exceptionThrown":
                details = answer["params"]["exceptionDetails"]
                self.messages.append(details.get("exception", {}).get("description") or details["text"])
            if answer.get("method") == "Log.entryAdded" and answer["params"]["entry"]["level"] == "error":
                self.messages.append(answer["params"]["entry"]["text"])
            if answer.get("id") == number:
                assert "error" not in answer, answer["error"]
                result: dict[str, Any] = answer["result"]
                return result

    def size(self, width: int, height: int, dark: bool = False) -> None:
        """Set the size of the window [px] and the colours the reader prefers."""
        self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600
        )
        features = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
        self.call("Emulation.setEmulatedMedia", features=features)

    def open(self, address: str | Path) -> None:
        """Load a page and wait until it has loaded; a path is opened as a file."""
        self.call("Page.navigate", url=address.absolute().as_uri() if isinstance(address, Path) else address)
        wait(lambda: self.value("document.readyState") == "complete", 60, f"{address} to load")

    def value(self, expression: str) -> Any:
        """Return the value of a JavaScript expression on the page; a promise is awaited."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def until(self, expression: str, seconds: float = 30.0) -> None:
        """Wait until a JavaScript expression is true."""
        wait(lambda: bool(self.value(expression)), seconds, expression)

    def picture(self, file: Path | None = None, whole: bool = False) -> np.ndarray:
        """Return what the page shows as colours 0 to 255, shape (height, width, 3); `whole`: below the window too."""
        import numpy as np
        from PIL import Image

        shot = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        data = base64.b64decode(shot["data"])
        if file is not None:
            file.write_bytes(data)
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))


def wait(holds: Callable[[], bool], seconds: float, what: str, pause: float = 0.05) -> None:
    """Wait until a condition holds, looking every `pause` seconds; fail with its description."""
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, f"waited {seconds:g} s for {what}"
        time.sleep(pause)


def chromium() -> str:
    """Return the path of Chromium; skip where there is none."""
    named = os.environ.get("FLEXROS_CHROMIUM", "")
    found = named or next(filter(None, map(shutil.which, NAMES)), "")
    if not found:
        pytest.skip("no Chromium on this machine: install the package chromium, or name one in FLEXROS_CHROMIUM")
    pytest.importorskip("websockets", reason="websockets drives Chromium: pip install websockets")
    pytest.importorskip("PIL", reason="Pillow reads screenshots: pip install pillow")
    return found


@contextlib.contextmanager
def opened_browser() -> Iterator[Browser]:
    """Give a browser and end it; skip where there is none."""
    executable = chromium()
    folder = Path(tempfile.mkdtemp(prefix="flexros_browser_"))
    try:
        browser = Browser(executable, folder)
        try:
            yield browser
        finally:
            browser.close()
    finally:
        shutil.rmtree(folder, ignore_errors=True)
