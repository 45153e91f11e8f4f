"""Opens the pages of results in headless Chromium and uses them as a reader would (scripts/page-check.sh).

Speaks the DevTools protocol over a pair of pipes, so that it needs Python and a browser alone.
"""

import argparse
import base64
import contextlib
import csv
import fcntl
import json
import os
import pathlib
import select
import subprocess
import sys
import tempfile
import time

WIDTHS = (390, 1200)
SCHEMES = ("light", "dark")
# Seconds until an answer or a state must be there
PATIENCE = 30


class Browser:
    """A headless browser; `errors` and `requests` are those of the page since it was opened."""

    def __init__(self, program, folder):
        # Numbers from 10 on, so that 3 and 4, where the browser expects its pipes, are free
        ends = [(fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10), os.close(end))[0] for end in (*os.pipe(), *os.pipe())]
        there, self.out, self.inp, back = ends
        self.folder = folder
        line = [
            program, "--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run",
            "--disable-background-networking", "--remote-debugging-pipe", f"--user-data-dir={folder}/profile", "about:blank",
        ]
        self.process = subprocess.Popen(
            line, close_fds=False, preexec_fn=lambda: (os.dup2(there, 3), os.dup2(back, 4)),
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )
        os.close(there)
        os.close(back)
        self.number, self.rest, self.session, self.loaded = 0, b"", None, False
        self.errors, self.requests, self.narrow = [], [], False

    def read(self, wait):
        if b"\0" not in self.rest:
            if not select.select([self.inp], [], [], wait)[0]:
                return None
            found = os.read(self.inp, 1 << 20)
            if not found:
                raise SystemExit("page-check: the browser ended")
            self.rest += found
        if b"\0" not in self.rest:
            return None
        message, self.rest = self.rest.split(b"\0", 1)
        return json.loads(message)

    def note(self, message):
        method, given = message.get("method"), message.get("params", {})
        if method == "Runtime.exceptionThrown":
            details = given["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description", details["text"]))
        elif method == "Runtime.consoleAPICalled" and given["type"] in ("error", "assert", "warning"):
            self.errors.append(" ".join(str(own.get("value", own)) for own in given["args"]))
        elif method == "Log.entryAdded" and given["entry"]["level"] in ("error", "warning"):
            self.errors.append(given["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requests.append(given["request"]["url"])
        elif method == "Page.loadEventFired":
            self.loaded = True

    def call(self, method, **given):
        self.number += 1
        message = {"id": self.number, "method": method, "params": given}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.out, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            answer = self.read(1)
            if answer is None:
                continue
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise SystemExit(f"page-check: {method}: {answer['error']['message']}")
                return answer["result"]
            self.note(answer)
        raise SystemExit(f"page-check: {method}: no answer within {PATIENCE} s")

    def attach(self):
        targets = self.call("Target.getTargets")["targetInfos"]
        page = next(target for target in targets if target["type"] == "page")
        self.session = self.call("Target.attachToTarget", targetId=page["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(self.folder))

    def open(self, path, width, scheme):
        self.errors, self.requests, self.loaded, self.narrow = [], [], False, width < 600
        self.call("Emulation.setTouchEmulationEnabled", enabled=self.narrow)
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        address = path.resolve().as_uri()
        self.call("Page.navigate", url=address)
        wait(lambda: self.value("document.readyState") == "complete" and self.loaded, "the page to load")
        return address

    def shown(self, panel):
        """Whether a panel is shown, and whether the figures in whose place it stands are."""
        style = lambda own: f"getComputedStyle({own}).display !== 'none'"
        own = f"document.querySelector('{panel}')"
        return [self.value(style(own)), self.value(style(f"{own}.previousElementSibling"))]

    def value(self, script):
        given = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in given:
            raise SystemExit(f"page-check: {script}: {given['exceptionDetails']['exception'].get('description')}")
        return given["result"].get("value")

    def mouse(self, kind, x, y):
        down = kind != "mouseReleased"
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=int(down), clickCount=1)

    def drag(self, *points):
        """Along these points: by a finger in a narrow window, which begins sideways, else by the mouse."""
        way = [tuple(a + share / 4 * (b - a) for a, b in zip(one, two)) for one, two in zip(points, points[1:]) for share in range(1, 5)]
        if self.narrow:
            touch = lambda kind, *at: self.call("Input.dispatchTouchEvent", type=kind, touchPoints=[{"x": x, "y": y} for x, y in at])
            touch("touchStart", points[0])
            for at in way:
                touch("touchMove", at)
            touch("touchEnd")
            return
        self.call("Input.dispatchMouseEvent", type="mouseMoved", x=points[0][0], y=points[0][1])
        self.mouse("mousePressed", *points[0])
        for at in way:
            self.mouse("mouseMoved", *at)
        self.mouse("mouseReleased", *points[-1])

    def key(self, name):
        text = {"Enter": "\r"}.get(name, name if len(name) == 1 else "")
        code = {"Enter": 13, "ArrowLeft": 37, "ArrowRight": 39, "ArrowDown": 40}.get(name, 0)
        given = {"key": name, "windowsVirtualKeyCode": code}
        if name == "Enter" or name.startswith("Arrow"):
            given["code"] = name
        self.call("Input.dispatchKeyEvent", type="keyDown", text=text, **given)
        self.call("Input.dispatchKeyEvent", type="keyUp", **given)

    def box(self, selector):
        """Left, top, width, height of an element that is scrolled into view."""
        return self.value(
            f"(() => {{ const own = document.querySelector({json.dumps(selector)}); own.scrollIntoView({{block: 'center'}});"
            " const r = own.getBoundingClientRect(); return [r.left, r.top, r.width, r.height]; })()"
        )

    def focus(self, selector):
        self.value(f"document.querySelector({json.dumps(selector)}).focus()")

    def picture(self, path):
        size = self.call("Page.getLayoutMetrics")["cssContentSize"]
        clip = {"x": 0, "y": 0, "width": size["width"], "height": min(size["height"], 6000), "scale": 1}
        data = self.call("Page.captureScreenshot", clip=clip, captureBeyondViewport=True)["data"]
        path.write_bytes(base64.b64decode(data))

    def close(self):
        self.session = None
        with contextlib.suppress(SystemExit, OSError):
            os.write(self.out, json.dumps({"id": 0, "method": "Browser.close"}).encode() + b"\0")
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()


def wait(holds, what):
    end = time.monotonic() + PATIENCE
    while not holds():
        if time.monotonic() > end:
            raise SystemExit(f"page-check: waited {PATIENCE} s for {what}")
        time.sleep(0.05)


def must(holds, said):
    if not holds:
        raise SystemExit(f"page-check: {said}")


def dots(browser, panel):
    """Brush, limits, sort, CSV and keyboard of a panel of dots."""
    own = f"document.querySelector('{panel}').drawn"
    kept = lambda: browser.value(f"{own}.table.kept.length")
    every = kept()
    left, top, width, height = browser.box(f"{panel} .u-over")
    browser.drag((left + 4, top + 4), (left + width * 0.5, top + 4), (left + width * 0.5, top + height - 4))
    brushed = kept()
    must(0 < brushed < every, f"{panel}: {brushed} of {every} rows kept by a brush over the left half")
    limits = browser.value(f"{own}.limits")
    within = f"{own}.table.kept.every((row) => {own}.value(row, 0) >= {limits[0][0]} && {own}.value(row, 0) <= {limits[0][1]})"
    must(browser.value(within), f"{panel}: rows outside of the brush are kept")
    table(browser, panel, brushed)
    browser.focus(f"{panel} .plot")
    browser.key("0")
    must(kept() == every, f"{panel}: 0 does not show all")
    browser.key("+")
    browser.key("ArrowRight")
    must(browser.value(f"{own}.view !== null") and kept() <= every, f"{panel}: + does not zoom")
    browser.key("0")
    browser.focus(f"{panel} tbody tr")
    browser.key("ArrowDown")
    browser.key("Enter")
    second = f"document.querySelector('{panel} tbody').children[1].classList.contains('picked') && {own}.ring !== null"
    must(browser.value(second), f"{panel}: Enter on the second row does not pick it")


def table(browser, panel, rows):
    """Sorts by the fourth column from the keyboard, both ways, and downloads what is kept."""
    own = f"document.querySelector('{panel}').drawn.table"
    values = f"{own}.order().map((row) => {own}.rows[row][3]).filter((value) => value !== null)"
    for down in (False, True):
        browser.focus(f"{panel} th:nth-child(4) button")
        browser.key("Enter")
        found = browser.value(values)
        must(found == sorted(found, reverse=down), f"{panel}: the column is not sorted, down: {down}")
    browser.value(f"[...document.querySelectorAll('{panel} button')].find((own) => own.textContent === 'Download CSV').click()")
    name = browser.folder / f"{browser.value(f'{own}.file')}.csv"
    wait(lambda: name.exists() and name.stat().st_size > 0, f"{name.name}")
    with name.open(newline="", encoding="utf-8") as file:
        lines = list(csv.reader(file))
    columns = browser.value(f"{own}.columns.length")
    must(len(lines) == rows + 1, f"{name.name}: {len(lines) - 1} rows, expected the {rows} of the table")
    must(all(len(line) == columns for line in lines), f"{name.name}: lines of other than {columns} values")
    name.unlink()


def curves(browser, panel):
    """A drag in one plot zooms all; keys pan, zoom and show all."""
    own = f"document.querySelector('{panel}').drawn"
    ranges = lambda: browser.value(f"{own}.plots.map((plot) => [plot.scales.x.min, plot.scales.x.max])")
    every = ranges()
    left, top, width, height = browser.box(f"{panel} .u-over")
    browser.drag((left + width * 0.3, top + height / 2), (left + width * 0.6, top + height / 2))
    zoomed = ranges()
    must(zoomed[0] != every[0] and zoomed[0] == zoomed[1] == zoomed[2], f"{panel}: a drag gives the times {zoomed}")
    browser.focus(f"{panel} .plots")
    browser.key("ArrowRight")
    must(ranges()[0][0] > zoomed[0][0], f"{panel}: an arrow key does not pan")
    browser.key("0")
    must(ranges() == every, f"{panel}: 0 does not show all")


def chart(browser, panel):
    """A row of the sheet shows its step, a number on the track its row; the map pans by keys; a box hides a layer."""
    own = f"document.querySelector('{panel}').drawn"
    centre = lambda: browser.value(f"[{own}.map.getCenter().lng, {own}.map.getZoom()]")
    shades = f"[...document.querySelectorAll('{panel} path.depth')].every((own) => getComputedStyle(own).fill.startsWith('rgb'))"
    must(browser.value(shades), f"{panel}: areas of a depth without its shade")
    if not browser.value(f"{own}.parts.some((part) => part.step !== null)"):
        return
    before = centre()
    browser.focus(".sheet tr[data-step]")
    browser.key("Enter")
    must(browser.value(f"document.querySelectorAll('{panel} path.picked').length") > 0, f"{panel}: a row marks no track")
    must(centre()[1] > before[1], f"{panel}: a row does not zoom the map")
    browser.box(f"{panel} .chart")
    browser.focus(f"{panel} .chart")
    east = centre()[0]
    browser.key("ArrowRight")
    wait(lambda: centre()[0] > east, "an arrow key to pan the map")
    numbers = f"document.querySelectorAll('{panel} .chart .number')"
    browser.value(f"{numbers}[0].click()")
    step = browser.value(f"{own}.own.tracks.find((track) => track[2] !== null)[4]")
    picked = browser.value("[...document.querySelectorAll('.sheet tr.picked')].map((row) => Number(row.dataset.step))")
    must(picked == [step], f"{panel}: the first number on the map marks the steps {picked}, expected {step}")
    count = browser.value(f"{numbers}.length")
    last = f"[...document.querySelectorAll('{panel} .layers label')].find((own) => own.textContent === 'track').control"
    browser.value(f"{last}.click()")
    must(count > 0 and browser.value(f"{numbers}.length") == 0, f"{panel}: the layer is not hidden")
    browser.value(f"{last}.click()")


USES = {"dots": dots, "time": curves, "map": chart}


def look(browser, path, pictures):
    """Opens a page in every width and scheme; uses its panels in each width."""
    name = f"{path.parent.name}-{path.stem}"
    for width in WIDTHS:
        for scheme in SCHEMES:
            address = browser.open(path, width, scheme)
            said = f"{path} at {width} px, {scheme}"
            wide = browser.value("document.documentElement.scrollWidth")
            must(wide <= width, f"{said}: {wide} px wide, expected no more than the window")
            kinds = browser.value(
                "JSON.parse(document.getElementById('data')?.textContent ?? '[]').map((own) => [own.id, own.data.kind])"
            )
            if pictures:
                browser.picture(pictures / f"{name}-{width}-{scheme}.png")
            for panel, kind in kinds:
                drawn = browser.value(f"document.querySelectorAll('#{panel} canvas, #{panel} path').length")
                must(drawn > 0 and browser.shown(f"#{panel}") == [True, False], f"{said}: {panel} is not in the place of its figures")
                if scheme == "light":
                    USES[kind](browser, f"#{panel}")
            out = [own for own in browser.requests if own != address and not own.startswith(("data:", "blob:"))]
            must(not out, f"{said}: requests {out}")
            must(not browser.errors, f"{said}: errors {browser.errors}")
    browser.call("Emulation.setEmulatedMedia", media="print")
    must(all(browser.shown(f"#{panel}") == [False, True] for panel, _ in kinds), f"{path}: printed without its figures")
    browser.call("Emulation.setEmulatedMedia", media="")
    browser.call("Emulation.setScriptExecutionDisabled", value=True)
    browser.open(path, WIDTHS[0], SCHEMES[0])
    must(all(browser.shown(f"#{panel}") == [False, True] for panel, _ in kinds), f"{path}: without scripts it lacks its figures")
    browser.call("Emulation.setScriptExecutionDisabled", value=False)
    print(f"{path}: {WIDTHS} px, {SCHEMES}: {len(kinds)} panels used, no error, no request")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("browser")
    parser.add_argument("folders", nargs="+", type=pathlib.Path, help="results with report.html")
    parser.add_argument("--pictures", type=pathlib.Path, help="folder for a picture of every page as it opens")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        browser = Browser(given.browser, pathlib.Path(folder))
        try:
            browser.attach()
            for results in given.folders:
                page = results / "report.html"
                must(page.is_file(), f"{results}: found no report.html, expected results with a report; run `report`")
                look(browser, page, given.pictures)
        finally:
            browser.close()


if __name__ == "__main__":
    sys.exit(main())
