"""Reports in a browser: no request, no error, no overflow, and responsive pictures.

    python -m benchmarks.reports RUN... [--axe axe.min.js] [--pictures FOLDER]

opens the report of every run in headless Chromium, as a desktop and as a phone, light and dark.
It needs `pip install playwright` and Debian's `chromium`; with axe-core's file it prints those
findings too.
"""

import argparse
import shutil
import sys
from pathlib import Path

VIEWS = {
    "desktop": (1440, 900, "light"),
    "desktop-dark": (1440, 900, "dark"),
    "phone": (390, 844, "light"),
    "phone-dark": (390, 844, "dark"),
}
LARGEST = 3_000_000
"""Bytes of a report."""
_AXE = "axe.run().then(r => r.violations.map(v => `${v.impact} ${v.id}: ${v.nodes[0].html}`))"
_SMALL = """[...document.querySelectorAll('.chart .area')].filter(
  a => a.getBoundingClientRect().width < 200 || a.getBoundingClientRect().height < 120).length"""


def main(arguments):
    """Print the faults of each report; 1 where there is any."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("--axe", type=Path)
    parser.add_argument("--pictures", type=Path)
    asked = parser.parse_args(arguments)
    browser = next(filter(None, map(shutil.which, ("chromium", "google-chrome"))), None)
    if browser is None:
        print("no Chromium was found")
        return 2
    from playwright.sync_api import sync_playwright

    wrong = 0
    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=browser, args=["--no-sandbox"])
        for run in asked.runs:
            file = run / "report.html"
            found = [f"{file.stat().st_size} bytes"] * (file.stat().st_size > LARGEST)
            for view in VIEWS:
                found += [f"{view}: {each}" for each in looked_at(opened, file, view, asked)]
            print(f"{run}: {file.stat().st_size / 1000:.0f} kB, {'; '.join(found) or 'well'}")
            wrong += bool(found)
        opened.close()
    return int(wrong > 0)


def looked_at(browser, file, view, asked):
    """The faults of a report in one view."""
    width, height, scheme = VIEWS[view]
    size = {"width": width, "height": height}
    page = browser.new_page(viewport=size, color_scheme=scheme)
    found = []
    page.on("console", lambda said: found.append(f"console: {said.text}"))
    page.on("pageerror", lambda error: found.append(f"error: {error}"))
    own = file.resolve().as_uri()
    page.on("request", lambda one: one.url != own and found.append(f"fetches {one.url[:60]}"))
    page.goto(own)
    if over := page.evaluate("document.documentElement.scrollWidth - innerWidth"):
        found.append(f"{over} pixels stick out")
    if small := page.evaluate(_SMALL):
        found.append(f"{small} pictures are too small")
    found += tried(page)
    if asked.pictures is not None:
        asked.pictures.mkdir(parents=True, exist_ok=True)
        page.reload()
        page.evaluate("scrollTo(0, 0)")  # the navigation stays at the top of what is seen
        page.screenshot(path=asked.pictures / f"{file.parent.name}-{view}.png", full_page=True)
    page.close()
    return found + (accessibility(browser, file, view, asked.axe) if asked.axe else [])


def tried(page):
    """Whether the first picture over time zooms, reads values and goes back."""
    charts = page.locator("figure.chart[data-joined]")
    if not charts.count():
        return []
    area, svg = charts.first.locator(".area"), charts.first.locator(".area svg")
    whole = svg.get_attribute("viewBox")
    area.hover()
    told = charts.first.locator(".readout").inner_text()
    area.focus()
    for key in ("+", "ArrowRight"):
        page.keyboard.press(key)
    inside = svg.get_attribute("viewBox")
    spoken = charts.first.locator("[aria-live]").inner_text()
    page.keyboard.press("Escape")
    back = svg.get_attribute("viewBox")
    checks = {
        "hovering reads nothing": "time" in told,
        "+ does not zoom": inside != whole,
        "arrow keys read nothing": "time" in spoken,
        "Escape does not go back": back == whole,
    }
    return [words for words, well in checks.items() if not well]


def accessibility(browser, file, view, axe):
    """The findings of axe-core."""
    width, height, scheme = VIEWS[view]
    # The page's policy would refuse any other script.
    context = browser.new_context(
        viewport={"width": width, "height": height}, color_scheme=scheme, bypass_csp=True
    )
    page = context.new_page()
    page.goto(file.resolve().as_uri())
    page.evaluate(axe.read_text(encoding="utf-8"))
    found = page.evaluate(_AXE)
    context.close()
    return found


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
