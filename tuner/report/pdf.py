"""A report as PDF, printed by a browser that is installed."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

BROWSERS = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "microsoft-edge",
    "msedge",
    "brave-browser",
)
"""Programs that print a page by the same options."""
PLACES = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    r"C:\Program Files\Google\Chrome\Application\chrome.exe",
    r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
)
"""Where they are without being on the path."""
SECONDS = 120


def pdf(page: bytes) -> bytes:
    """The page as a browser prints it.

    Raises:
        ValueError: where there is no such browser, or it prints nothing.
    """
    browser = _browser()
    with tempfile.TemporaryDirectory(prefix="tuner-report-") as kept:
        source, target = Path(kept) / "report.html", Path(kept) / "report.pdf"
        source.write_bytes(page)
        command = [
            browser,
            "--headless",
            "--disable-gpu",
            "--no-first-run",
            "--no-pdf-header-footer",
            f"--user-data-dir={kept}/profile",
            *_unboxed(),
            f"--print-to-pdf={target}",
            source.as_uri(),
        ]
        try:
            subprocess.run(command, capture_output=True, check=False, timeout=SECONDS)
        except subprocess.TimeoutExpired:
            raise ValueError(
                f"{browser} did not print the report within {SECONDS} s; open report.html in a "
                "browser and print it there"
            ) from None
        if not target.is_file():
            raise ValueError(
                f"{browser} printed nothing; open report.html in a browser and print it there"
            )
        return target.read_bytes()


def _browser() -> str:
    found = next((there for name in BROWSERS if (there := shutil.which(name))), None)
    found = found or next((place for place in PLACES if Path(place).is_file()), None)
    if found is None:
        raise ValueError(
            "no browser was found to print the PDF (Chromium, Chrome, Edge); install one, or open "
            "report.html and print it there"
        )
    return found


def _unboxed() -> list[str]:
    """The superuser's browser starts without its sandbox or not at all; the page is our own."""
    root = hasattr(os, "geteuid") and os.geteuid() == 0
    return ["--no-sandbox"] if root else []
