"""A headless Chromium at the end of a pipe, by its DevTools protocol and the Python standard library alone."""

import base64
import json
import os
import shutil
import subprocess
import tempfile
import time

# Longest wait in s for anything that a page does: a diagnosis takes a tenth of it on a busy computer.
LONGEST = 120


def program():
    """Path of a Chromium, or None."""
    names = ("chromium", "chromium-browser", "google-chrome")
    return next((path for path in map(shutil.which, names) if path), None)


class Browser:
    """A browser with one page, ended at the end of a `with` block."""

    def __init__(self, address, before=""):
        self.folder = tempfile.mkdtemp()
        to_browser, self.to = os.pipe()
        self.back, from_browser = os.pipe()

        def plug_in():
            # Chromium reads at descriptor 3 and writes at 4; copies first, as either may be one of them.
            copies = os.dup2(to_browser, 60), os.dup2(from_browser, 61)
            os.dup2(copies[0], 3)
            os.dup2(copies[1], 4)

        words = [program(), "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-dev-shm-usage",
                 "--remote-debugging-pipe", f"--user-data-dir={self.folder}", "about:blank"]
        self.process = subprocess.Popen(words, preexec_fn=plug_in, close_fds=False,
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self.last, self.text, self.events, self.addresses, self.session = 0, b"", [], [], None
        targets = self.call("Target.getTargets")["targetInfos"]
        page = next(one for one in targets if one["type"] == "page")
        self.session = self.call("Target.attachToTarget", targetId=page["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log", "DOM"):
            self.call(f"{domain}.enable")
        self.call("Page.addScriptToEvaluateOnNewDocument", source=KEEP_DOWNLOADS + before)
        self.go(address)

    def go(self, address):
        """Loads a page, of a desk's size."""
        self.resize(1200)
        self.shade(False)
        self.call("Page.navigate", url=address)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        os.close(self.to)
        os.close(self.back)
        shutil.rmtree(self.folder, ignore_errors=True)

    def call(self, method, **parameters):
        """Asks the browser and waits for its answer."""
        self.last += 1
        message = {"id": self.last, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.read()
            if answer.get("id") == self.last:
                assert "error" not in answer, f"{method}: {answer.get('error')}"
                return answer["result"]
            self.note(answer)

    def note(self, event):
        """Keeps an event, and the address that it asks the network for."""
        self.events.append(event)
        if event.get("method") == "Network.requestWillBeSent":
            self.addresses.append(event["params"]["request"]["url"])

    def read(self):
        """The next message of the browser."""
        while b"\0" not in self.text:
            part = os.read(self.back, 1 << 16)
            assert part, "the browser has ended"
            self.text += part
        message, _, self.text = self.text.partition(b"\0")
        return json.loads(message)

    def resize(self, width, height=900):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600)

    def shade(self, dark):
        value = "dark" if dark else "light"
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": value}])

    def run(self, script):
        """The value of a script, awaited."""
        found = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in found, found["exceptionDetails"].get("exception", found)
        return found["result"].get("value")

    def wait(self, script, longest=LONGEST):
        """Waits until a script gives something true."""
        until = time.monotonic() + longest
        while time.monotonic() < until:
            found = self.run(f"Boolean({script})")
            if found:
                return
            time.sleep(0.1)
        said = self.run("[...document.querySelectorAll('[role=status],[role=alert]')].map((one) => one.textContent).join(' | ')")
        raise AssertionError(f"waited {longest} s for: {script}; the page says: {said}")

    def click(self, selector):
        """Clicks with the mouse, where an element is seen."""
        at = self.run(f"(() => {{ const one = document.querySelector({json.dumps(selector)}); one.scrollIntoView({{block: 'center'}});"
                      "const box = one.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]; })()")
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=at[0], y=at[1], button="left", clickCount=1)

    def key(self, key, code, number):
        for kind in ("keyDown", "keyUp"):
            text = {"text": "\r"} if key == "Enter" and kind == "keyDown" else {}
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=code, windowsVirtualKeyCode=number, **text)

    def files(self, selector, *paths):
        """Chooses files in an input."""
        root = self.call("DOM.getDocument")["root"]["nodeId"]
        node = self.call("DOM.querySelector", nodeId=root, selector=selector)["nodeId"]
        self.call("DOM.setFileInputFiles", nodeId=node, files=[str(path) for path in paths])

    def picture(self, path, whole=True):
        """Writes what is seen as PNG."""
        found = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        with open(path, "wb") as file:
            file.write(base64.b64decode(found["data"]))

    def complaints(self):
        """Errors of the console and of the page's rules so far."""
        said = []
        for event in self.events:
            if event.get("method") == "Log.entryAdded":
                said.append(event["params"]["entry"]["text"])
            if event.get("method") == "Runtime.exceptionThrown":
                said.append(event["params"]["exceptionDetails"]["text"])
        return said


# Downloads are kept in the page, where a test can read them.
KEEP_DOWNLOADS = """
window.saved = {};
const click = HTMLAnchorElement.prototype.click;
const made = new Map();
const create = URL.createObjectURL;
URL.createObjectURL = (blob) => { const address = create.call(URL, blob); made.set(address, blob); return address; };
HTMLAnchorElement.prototype.click = function () {
  if (!this.download) return click.call(this);
  made.get(this.href).text().then((text) => { window.saved[this.download] = text; });
};
"""
