"""The page under test as its user has it, and the native program beside it."""

import http.server
import json
import os
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
ROOT = HERE.parent.parent
PAGE = pathlib.Path(sys.argv[1]).resolve() / "index.html"
PROGRAM = pathlib.Path(sys.argv[2]).resolve()
# Mathematical functions of WebAssembly for the native program.
MATHEMATICS = pathlib.Path(sys.argv[3]).resolve()
READY = "document.documentElement?.dataset.ready"
RUNS = "document.querySelectorAll('#runs > li').length"


# One page for all tests, as a load of it compiles the program twice: as it was loaded, without a recording or an answer.
FRESH = """(() => {
  const all = (which) => [...document.querySelectorAll(which)];
  for (let one; (one = document.querySelector('#runs [aria-label^=Remove]')); ) one.click();
  for (const one of all('#questions button[type=button]')) one.click();
  for (const one of all('input[type=radio]')) if (one.defaultChecked) one.click();
  for (const one of all('input[type=checkbox]')) if (one.checked !== one.defaultChecked) one.click();
  for (const one of all('#recording input:not([type=radio], [type=checkbox])')) one.value = one.defaultValue;
  for (const one of all('input[type=file]')) one.value = '';
  for (const one of all('[role=status], #answer')) one.replaceChildren();
  document.getElementById('profile').value = 'reversing';
  document.getElementById('reveal').hidden = true;
  if (window.kept) Object.defineProperty(Navigator.prototype, 'serial', kept);
  window.saved = {};
  plugIn();
})()"""


def fresh(browser):
    browser.events.clear()
    browser.resize(1200)
    browser.shade(False)
    browser.run(FRESH)


def native(folder, *words, preload=""):
    """Standard output of the program. Exit status 1 is an incomplete result."""
    done = subprocess.run([PROGRAM, *words], cwd=folder, capture_output=True, text=True, timeout=120,
                          env={**os.environ, "LD_PRELOAD": str(preload)})
    assert done.returncode in (0, 1), done.stderr
    return done.stdout


def same(first, second):
    """Whether two documents or run files say the same but for the last digits of another mathematical library."""
    subprocess.run([sys.executable, ROOT / "tests/windows/same.py", first, second], check=True)


def saved(browser, name):
    browser.wait(f"window.saved[{json.dumps(name)}] !== undefined")
    return browser.run(f"window.saved[{json.dumps(name)}]")


def press(browser, text):
    """Presses the first button with this text."""
    browser.run(f"[...document.querySelectorAll('button')].find((one) => one.textContent === {json.dumps(text)}).click()")


def quiet(browser):
    assert browser.complaints() == [], browser.complaints()


def rows(text):
    """Rows of a run file without the time at which they came: what the board said is the same, when it came is not."""
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    columns = [k for k, name in enumerate(lines[0].split(",")) if name != "host_t_s"]
    return [[line.split(",")[k] for k in columns] for line in lines]


def without_clock(document):
    """A document without the time that it took."""
    return re.sub(r'"elapsed_s": [0-9.e-]+', '"elapsed_s": 0', document)


class Silent(http.server.SimpleHTTPRequestHandler):
    """A static server that prints nothing."""

    def log_message(self, *_):
        pass
