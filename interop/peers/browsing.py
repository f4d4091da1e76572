"""A page in a browser, and the server that it comes from, as tests use them."""

from __future__ import annotations

import base64
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from selenium import webdriver
from selenium.common.exceptions import TimeoutException
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.support.ui import WebDriverWait

PATIENCE = 40.0


_OPTIONS = """
--headless=new --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking
--disable-component-update --disable-sync --disable-dev-shm-usage --window-size=1280,800 --hide-scrollbars
--disable-features=BackForwardCache --disable-gpu-rasterization
""".split()  # noqa: SIM905  shorter as text


@contextmanager
def start_chromium() -> Iterator[Any]:
    """Start Debian's Chromium without a window; give its driver, and end it with the context."""
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or ""
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    folder = tempfile.mkdtemp()
    for option in (*_OPTIONS, f"--user-data-dir={folder}"):
        options.add_argument(option)
    driver = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
    try:
        yield driver
    finally:
        driver.quit()
        shutil.rmtree(folder, ignore_errors=True)


class Browser:
    """A page in headless Chromium."""

    def __init__(self, driver: Any) -> None:
        self.driver = driver

    def open(self, link: str) -> None:
        """Load a link; one that differs only behind # is loaded anew, too."""
        self.driver.get("about:blank")
        self.driver.get(link)

    def run(self, script: str, *values: Any) -> Any:
        """Run JavaScript; return what it returns."""
        return self.driver.execute_script(script, *values)

    def wait(self, script: str, *values: Any, seconds: float = PATIENCE) -> Any:
        """Wait until an expression in JavaScript is true, and return it. Its values are ``arguments[0]``..."""
        found: list[Any] = []

        def look(_: Any) -> bool:
            found[:] = [self.run(f"return {script}", *values)]
            return bool(found[0])

        try:
            WebDriverWait(self.driver, seconds, 0.1).until(look)
        except TimeoutException:
            shown = self.run("return document.body.innerText.slice(0, 2000)")
            raise AssertionError(f"never true: {script} {values or ''}; the page shows:\n{shown}") from None
        return found[0]

    def wait_for_text(self, text: str, seconds: float = PATIENCE) -> None:
        """Wait until the page shows a text."""
        self.wait("document.body.innerText.includes(arguments[0])", text, seconds=seconds)

    def click(self, selector: str, text: str = "") -> None:
        """Click the first element that fits a selector, and has a text, as soon as it is there."""
        find = "[...document.querySelectorAll(arguments[0])].find((each) => each.textContent.includes(arguments[1]))"
        self.wait(find, selector, text)
        self.run(f"{find}.click()", selector, text)

    def saved(self, selector: str, text: str) -> bytes:
        """Click a button as `click` does; return the file that the page saves."""
        self.run(
            "const make = URL.createObjectURL; window.saved = '';"
            "URL.createObjectURL = (blob) => { URL.createObjectURL = make; const reader = new FileReader();"
            "reader.onload = () => { window.saved = reader.result; }; reader.readAsDataURL(blob); return make(blob); };"
        )
        self.click(selector, text)
        return base64.b64decode(self.wait("window.saved").partition(",")[2])

    @contextmanager
    def pressed(self, selector: str, text: str) -> Iterator[None]:
        """Press the mouse's button on the first element that fits, and release it there with the context."""
        find = "[...document.querySelectorAll(arguments[0])].find((each) => each.textContent.includes(arguments[1]))"
        box = self.wait(f"{find}?.getBoundingClientRect().toJSON()", selector, text)
        at = {"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2, "button": "left", "clickCount": 1}
        self.driver.execute_cdp_cmd("Input.dispatchMouseEvent", {"type": "mousePressed", **at})
        yield
        self.driver.execute_cdp_cmd("Input.dispatchMouseEvent", {"type": "mouseReleased", **at})

    def type(self, selector: str, text: str) -> None:
        """Fill a field, as if one typed."""
        self.wait("document.querySelector(arguments[0])", selector)
        self.run(
            "const field = document.querySelector(arguments[0]); field.focus(); field.value = arguments[1];"
            "field.dispatchEvent(new Event('input', {bubbles: true}));"
            "field.dispatchEvent(new Event('change', {bubbles: true}));",
            selector,
            text,
        )

    def choose(self, selector: str, value: str) -> None:
        """Choose an entry of a list by its value."""
        self.wait("document.querySelector(arguments[0])", selector)
        self.run(
            "const list = document.querySelector(arguments[0]); list.value = arguments[1];"
            "list.dispatchEvent(new Event('change', {bubbles: true}));",
            selector,
            value,
        )

    def resize(self, width: int, height: int) -> None:
        """Set the size of the page in pixels."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)

    def prefer(self, theme: str) -> None:
        """Let the system be light or dark; empty: as it is."""
        features = [{"name": "prefers-color-scheme", "value": theme}] if theme else []
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})

    def picture(self, file: Path) -> None:
        """Write what is seen as PNG."""
        assert self.driver.save_screenshot(str(file))

    def complaints(self) -> list[str]:
        """Return what the browser's console says since the last call: errors, and what was refused."""
        said = [each["message"] for each in self.driver.get_log("browser") if each["level"] in ("SEVERE", "WARNING")]
        # Tests read pixels more often than users, and have no graphics card.
        return [text for text in said if "willReadFrequently" not in text and "WebGL" not in text]


class Web:
    """A running ``pyros1 web``."""

    def __init__(self, process: subprocess.Popen[str], link: str) -> None:
        self.process = process
        self.link = link

    def page(self, panel: str) -> str:
        """Return the link of a panel."""
        return f"{self.link}#{panel}"
