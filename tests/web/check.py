"""Tests of the page in a headless Chromium: `check.py FOLDER_OF_THE_PAGE NATIVE_PROGRAM MATHEMATICS [FILTER]`."""

import base64
import functools
import http.server
import json
import pathlib
import sys
import tempfile
import threading
import time

from browser import Browser
from page import HERE, MATHEMATICS, PAGE, READY, ROOT, RUNS, Silent, fresh, native, press, quiet, rows, same, saved, without_clock


def it_asks_nothing_of_the_network(browser, folder):
    # Of all tests so far.
    asked = [address for address in browser.addresses if not address.startswith(("file:", "blob:", "data:"))]
    assert len(browser.addresses) > 1 and asked == [], asked
    tries = "Promise.allSettled([fetch('https://example.org'), new Promise((yes, no) => {" \
            "const one = new Image(); one.onload = yes; one.onerror = no; one.src = 'https://example.org/a.png'; })])"
    found = browser.run(f"{tries}.then((all) => all.map((one) => one.status))")
    assert found == ["rejected", "rejected"], found
    refused = [text for text in browser.complaints() if "Content Security Policy" in text]
    assert all(any(rule in text for text in refused) for rule in ("connect-src", "img-src")), refused


def it_works_from_a_static_server_by_keyboard_alone(browser, folder):
    handler = functools.partial(Silent, directory=PAGE.parent)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        browser.go(f"http://127.0.0.1:{server.server_port}/")
        browser.wait(f"location.protocol === 'http:' && {READY}")
        server.shutdown()
    for _ in range(12):
        browser.key("Tab", "Tab", 9)
        if browser.run("document.activeElement.id") == "example":
            break
    browser.key("Enter", "Enter", 13)
    browser.wait(f"{RUNS} === 1")
    # The focus stands where the next key says "diagnose", and then at the answer.
    browser.wait("document.activeElement.id === 'diagnose'")
    browser.key("Enter", "Enter", 13)
    browser.wait("document.activeElement === document.querySelector('#answer h3')")
    browser.key("Tab", "Tab", 9)
    assert browser.run("document.activeElement.textContent") == "Save the report"
    quiet(browser)


def a_log_is_dropped_asked_about_and_saved(browser, folder):
    log = ROOT / "docs/tutorial/log.csv"
    native(folder, "import", log, "--supply", "12", "-o", "native.csv", "--save-map", "native.toml")
    browser.files("#files", log)
    browser.wait("document.querySelector('input[name=supply]')")
    assert browser.run("document.activeElement.name") == "supply"
    browser.call("Input.insertText", text="12")
    browser.key("Enter", "Enter", 13)
    browser.wait(f"{RUNS} === 1")
    assert not browser.run("Boolean(document.querySelector('#questions form'))")
    press(browser, "Save the run file")
    (folder / "page.csv").write_text(saved(browser, "log.run.csv"))
    same(folder / "native.csv", folder / "page.csv")
    press(browser, "Save the mapping")
    mapping = [line for line in (folder / "native.toml").read_text().splitlines() if not line.startswith("#")]
    assert saved(browser, "map.toml").split() == "\n".join(mapping).split()
    quiet(browser)
    # Nobody has described its motor: it is fitted.
    assert browser.run("document.querySelector('input[name=motor]:checked').value") == "fit"
    browser.click("#compare")
    browser.wait("document.querySelector('iframe')?.title === 'Recorded against simulated'")
    press(browser, "Save the fitted motor")
    assert "inertia_kg_m2" in saved(browser, "compared.toml")
    # The mapping answers what was asked.
    (folder / "map.toml").write_text((folder / "native.toml").read_text())
    browser.files("#mapping", folder / "map.toml")
    browser.files("#files", log, folder / "native.csv")
    browser.wait(f"{RUNS} === 3")


def logs_of_one_bench_are_asked_about_together(browser, folder):
    rows = "".join(f"{10 * k},0,{8.5 * (k % 7)},{255 if k > 9 else 0}\n" for k in range(60))
    for name in ("first.csv", "second.csv"):
        (folder / name).write_text(f"millis,Setpoint,Input,Output\n{rows}")
    (folder / "broken.csv").write_bytes(bytes(range(256)))
    browser.files("#files", *(folder / name for name in ("first.csv", "broken.csv", "second.csv")))
    browser.wait("document.querySelectorAll('#questions form').length === 2")
    # The file that is no log is named, and keeps nothing out.
    browser.wait("document.getElementById('look-said').textContent.includes('broken.csv')")
    # A measurement that may be either has a field for both.
    names = browser.run("[...document.querySelector('#questions form').querySelectorAll('input')].map((one) => one.name)")
    assert {"position", "speed", "command", "supply"} <= set(names), names
    units = browser.run("[...document.querySelector('input[name=speed]').list.options].map((one) => one.value)")
    assert "Input:rpm" in units, units
    for name, value in (("speed", "Input:rpm"), ("command", "Output:pwm"), ("supply", "9")):
        browser.run(f"document.querySelector('#questions [name={name}]').value = '{value}'")
    browser.run("document.querySelector('#questions form').requestSubmit()")
    browser.wait("document.querySelectorAll('#questions form').length === 1")
    # The supply is that of the bench; columns are those of the log.
    assert browser.run("['supply', 'speed'].map((name) => document.querySelector(`#questions [name=${name}]`).value)") == ["9", ""]
    quiet(browser)


def the_example_is_diagnosed_in_two_clicks(browser, folder):
    browser.click("#example")
    browser.wait(f"{RUNS} === 1 && !document.getElementById('diagnose').disabled")
    browser.click("#diagnose")
    browser.wait("!document.getElementById('progress').hidden")
    browser.wait("document.getElementById('sentence')")
    assert "voltage drop" in browser.run("document.getElementById('sentence').textContent")
    for label in ("Save the report", "Save as JSON", "Save the motor of the diagnosis"):
        press(browser, label)
    assert "voltage drop" in saved(browser, "diagnose.html")
    assert json.loads(saved(browser, "diagnose.json"))["effects"] == ["voltage_drop"]
    motor = saved(browser, "diagnosed.toml")
    assert "[effects.voltage_drop]" in motor
    # The report's own script runs in a frame that reaches nothing of the page.
    frame = browser.run("document.querySelector('iframe').getAttribute('sandbox')")
    assert frame == "allow-scripts", frame
    quiet(browser)
    (folder / "motor.toml").write_text(motor)
    browser.click("input[value=file]")
    browser.files("#motor-file-input", folder / "motor.toml")
    browser.wait("document.getElementById('motor-said').textContent.includes('is read')")
    browser.click("#compare")
    browser.wait("document.querySelector('iframe')?.title === 'Recorded against simulated'")


def a_diagnosis_is_stopped_and_asked_again(browser, folder):
    browser.click("#example")
    browser.wait(f"{RUNS} === 1")
    browser.click("#diagnose")
    browser.wait("document.getElementById('bar').value > 0")
    browser.click("#stop")
    browser.wait("document.getElementById('answer-said').textContent.includes('Stopped')")
    assert browser.run(RUNS) == 1
    browser.click("#check")
    browser.wait("document.querySelector('#answer h3')?.textContent.startsWith('No findings')")
    quiet(browser)


def a_recording_of_the_virtual_board_is_shown_while_it_comes(browser, folder):
    # Ten minutes: it is still coming when it is looked at, however slow the machine is.
    browser.run("document.getElementById('duration').value = '600'")
    browser.click("#record")
    browser.wait("!document.getElementById('stop-record').hidden")
    browser.wait("/^[1-9]\\d* samples, none lost/.test(document.getElementById('record-said').textContent)")
    browser.wait("document.querySelector('#live canvas')")
    assert browser.run(RUNS) == 0
    browser.click("#stop-record")
    browser.wait(f"{RUNS} === 1")
    browser.run("document.getElementById('duration').value = '1.5'")
    browser.click("#record")
    browser.wait(f"{RUNS} === 2")
    assert browser.run("document.getElementById('record-said').textContent") == "500 samples, none lost; complete"
    quiet(browser)


def a_board_is_recorded_over_web_serial(browser, folder):
    wire = ROOT / "fixtures/uno_step3.log"
    native(folder, "replay", wire, "-o", "native.csv")
    browser.run(f"setWire({json.dumps(wire.read_text())})")
    browser.click("input[value=board]")
    browser.run("document.getElementById('profile').value = 'step'; document.getElementById('duration').value = '2'")
    browser.click("#record")
    browser.wait(f"{RUNS} === 1")
    browser.wait("window.opened === 0")
    press(browser, "Save the run file")
    page = saved(browser, "recorded.csv")
    quiet(browser)

    assert rows(page) == rows((folder / "native.csv").read_text())
    assert 'name = "USB 2341:0043"' in page


def a_board_that_prints_text_is_recorded_over_web_serial(browser, folder):
    wire = ROOT / "fixtures/plain_sketch.log"
    native(folder, "replay", wire, "-o", "native.csv")
    browser.run(f"setTextWire({json.dumps(wire.read_text())})")
    browser.click("input[value=text]")
    browser.run("document.getElementById('duration').value = '2'; document.getElementById('text-supply').value = '4,5'")
    browser.click("#record")
    browser.wait("document.getElementById('record-said').textContent.includes('Counts per revolution')")
    assert browser.run("document.activeElement.id") == "text-counts"
    assert "\nhint: " in browser.run("document.getElementById('record-said').textContent")
    browser.call("Input.insertText", text="720")
    browser.click("#record")
    browser.wait(f"{RUNS} === 1")
    browser.wait("window.opened === 0")
    assert browser.run("document.getElementById('record-said').textContent") == "400 samples, none lost; complete"
    press(browser, "Save the run file")
    assert rows(saved(browser, "recorded.csv")) == rows((folder / "native.csv").read_text())
    assert browser.run("port.baud") == 115200
    # Lines are lost on the wire, and the recording is stopped.
    lines = wire.read_text().splitlines()
    browser.run(f"setTextWire({json.dumps(chr(10).join(lines[:60] + lines[63:]))})")
    browser.run("document.getElementById('duration').value = '60'")
    browser.click("#record")
    browser.wait("/^\\d+ samples, 7 lost/.test(document.getElementById('record-said').textContent)")
    browser.click("#stop-record")
    browser.wait(f"{RUNS} === 2")
    assert "7 lost; ended: stopped" in browser.run("document.getElementById('record-said').textContent")
    quiet(browser)


def without_web_serial_the_page_says_how_to_go_on(browser, folder):
    browser.run("delete navigator.serial; window.kept = Object.getOwnPropertyDescriptor(Navigator.prototype, 'serial'); delete Navigator.prototype.serial")
    browser.click("input[value=board]")
    said = browser.run("document.getElementById('no-serial').hidden ? '' : document.getElementById('no-serial').textContent")
    assert "Chrome or Edge" in said and "drop it above" in said, said
    assert browser.run("document.getElementById('record').disabled")
    browser.click("input[name=source][value=virtual]")
    assert not browser.run("document.getElementById('record').disabled")


def a_hidden_effect_is_revealed_by_a_button_alone(browser, folder):
    browser.click("#hide")
    browser.wait("!document.getElementById('reveal').hidden")
    press(browser, "Save the run file")
    header = [line for line in saved(browser, "hidden.csv").splitlines() if line.startswith("#")]
    press(browser, "Reveal it")
    effect = browser.run("document.getElementById('hidden-said').textContent").split(": ")[1].split(".")[0]
    assert effect.replace(" ", "_") in browser.run("motorlab.ask('offered', '')")
    assert not any(effect in line or effect.replace(" ", "_") in line for line in header), header


def text_of_a_file_is_never_markup(browser, folder):
    mark = "<img src=x onerror=window.hit=1>"
    name = f"{mark.replace('/', '')}.csv"
    (folder / name).write_text(f"t_ms,pwm{mark},counts,{mark}\n" + "".join(f"{10 * k},100,{3 * k},{k}\n" for k in range(50)))
    run = native(folder, "simulate", "--duration", "1", "--ts", "0.01", "-o", "run.csv") and (folder / "run.csv").read_text()
    (folder / "<b>run.csv").write_text(run.replace('profile = "step"', f'profile = "{mark}"'))
    browser.files("#files", folder / name, folder / "<b>run.csv")
    browser.wait(f"document.querySelector('#questions form') && {RUNS} === 1")
    browser.click("#compare")
    browser.wait("document.querySelector('iframe')")
    time.sleep(0.5)
    assert not browser.run("Boolean(window.hit || document.querySelector('[onerror], #runs b'))")
    quiet(browser)


# Feeds texts to the page, as files and as bytes of a board; gives the answers.
FEED = """async (name, texts, mapping) => {
  const said = [];
  const asked = (asking) => asking.then(() => 'answered', (error) => error.message);
  for (const text of texts) {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    said.push(await asked(motorlab.ask('look', name, bytes, '{}', mapping)));
    for (const source of SOURCES) {
      const order = { profile: 'step', duration_s: 1, sample_time_s: 0.01, source };
      const recording = asked(motorlab.ask('record', JSON.stringify(order)));
      motorlab.tell('serial_received', bytes);
      motorlab.tell('serial_gone');
      said.push(await recording);
    }
  }
  return said;
}"""
TEXT_BOARD = {"kind": "text", "port": "fed", "baud": 115200, "counts_per_rev": 720, "supply_v": 9, "has_profile": True}
SOURCES = [{"kind": "board", "port": "fed"}] + [{**TEXT_BOARD, "columns": one} for one in ("", "t_us,counts,pwm", "counts")]


def the_whole_corpus_gets_an_answer(browser, folder):
    folders = ("fuzz/seeds", "fuzz/dictionaries", "fixtures")
    files = sorted(path for name in folders for path in (ROOT / name).rglob("*") if path.is_file())
    feed = FEED.replace("SOURCES", json.dumps(SOURCES))
    fed = answered = 0
    for path in files:
        mapping, between, whole = path.read_bytes().rpartition(b"\n----\n")
        # Cut off, and with bytes that are turned over.
        texts = [whole, whole[: len(whole) // 4], whole[: len(whole) * 3 // 4],
                 bytes(byte ^ 0xFF if k % 97 == 13 else byte for k, byte in enumerate(whole))]
        texts = json.dumps([base64.b64encode(text).decode() for text in texts])
        said = browser.run(f"({feed})({json.dumps(path.name)}, {texts}, {json.dumps(mapping.decode())})")
        assert all(said) and not any("program failed" in one for one in said), (path, said)
        fed += len(said)
        answered += said.count("answered")
    quiet(browser)
    print(f"{len(files)} files, fed {fed} times: {answered} are read, {fed - answered} refused")
    assert answered > len(files)


# Name, and words of the program that give it: the page is compared with them.
RECORDINGS = (
    ("sagging.csv", "capture virtual:?effect=voltage_drop&seed=7&speed=max --profile reversing --duration 3 --ts 0.003"),
    ("backlash.csv", "capture virtual:?effect=backlash&seed=3&speed=max --profile reversing --duration 3 --ts 0.005"),
    ("uno.csv", f"replay {ROOT}/fixtures/uno_step3.log"),
    ("imported.csv", f"import {ROOT}/docs/tutorial/log.csv --supply 12"),
    ("short.csv", "simulate --duration 0.02 --ts 0.003"),
)
DOCUMENTS = (
    ("check", "sagging.csv"), ("check", "uno.csv"), ("check", "imported.csv"), ("check", "short.csv"),
    ("compare", "sagging.csv"), ("compare", "backlash.csv"), ("compare", "uno.csv"),
    ("diagnose", "sagging.csv"), ("diagnose", "uno.csv"), ("diagnose", "short.csv"),
)


def ten_documents_are_those_of_the_native_program(browser, folder):
    for name, words in RECORDINGS:
        native(folder, *words.split(), "-o", name)
    for verb, name in DOCUMENTS:
        question = {"runs": [{"name": name, "text": (folder / name).read_text()}], "asked": f"motorlab {verb} {name}"}
        told = browser.run(f"motorlab.ask('{verb}_runs', {json.dumps(json.dumps(question))})")
        page = told if verb == "check" else json.loads(told)["document"]
        # With the mathematical functions of WebAssembly, the native program prints the same bytes. With those of the C library some last
        # digits of a diagnosis differ.
        alike = native(folder, verb, name, "--json", preload=MATHEMATICS)
        assert without_clock(page) == without_clock(alike.rstrip("\n")), (verb, name)
        (folder / "native.json").write_text(native(folder, verb, name, "--json"))
        (folder / "page.json").write_text(page)
        same(folder / "native.json", folder / "page.json")


def it_fits_a_phone_in_light_and_dark(browser, folder):
    papers = []
    for dark in (False, True):
        browser.resize(390)
        browser.shade(dark)
        browser.click("#example")
        browser.wait(f"{RUNS} === {1 + dark}")
        browser.click("input[name=source][value=text]")
        for kind in ("form", "sheet"):
            browser.click(f"input[name=motor][value={kind}]")
            wide = browser.run("[...document.querySelectorAll('body *')].filter((one) => one.getBoundingClientRect().right > 390.5)"
                               ".map((one) => one.outerHTML.slice(0, 80))")
            assert wide == [], wide
        papers.append(browser.run("getComputedStyle(document.body).backgroundColor"))
    assert papers == ["rgb(255, 255, 255)", "rgb(13, 17, 23)"], papers


def every_control_has_a_name(browser, folder):
    browser.files("#files", ROOT / "docs/tutorial/log.csv")
    browser.wait("document.querySelector('#questions form')")
    browser.click("#example")
    browser.wait(f"{RUNS} === 1")
    browser.run("window.unseen = [...document.querySelectorAll('[hidden]')]; unseen.forEach((one) => (one.hidden = false));"
                "document.querySelectorAll('details').forEach((one) => (one.open = true))")
    roles = {"button", "textbox", "combobox", "radio", "checkbox", "slider", "link", "progressbar", "image"}
    nodes = browser.call("Accessibility.getFullAXTree")["nodes"]
    controls = [node for node in nodes if node.get("role", {}).get("value") in roles and not node.get("ignored")]
    nameless = [node["role"]["value"] for node in controls if not node.get("name", {}).get("value")]
    browser.run("unseen.forEach((one) => (one.hidden = true))")
    assert len(controls) > 60 and nameless == [], (len(controls), nameless)
    twice = browser.run("[...document.querySelectorAll('[id]')].map((one) => one.id).filter((id, k, all) => all.indexOf(id) !== k)")
    assert twice == [], twice


TESTS = [
    a_board_that_prints_text_is_recorded_over_web_serial,
    a_log_is_dropped_asked_about_and_saved,
    logs_of_one_bench_are_asked_about_together,
    the_example_is_diagnosed_in_two_clicks,
    a_diagnosis_is_stopped_and_asked_again,
    a_recording_of_the_virtual_board_is_shown_while_it_comes,
    a_board_is_recorded_over_web_serial,
    without_web_serial_the_page_says_how_to_go_on,
    a_hidden_effect_is_revealed_by_a_button_alone,
    text_of_a_file_is_never_markup,
    the_whole_corpus_gets_an_answer,
    ten_documents_are_those_of_the_native_program,
    it_fits_a_phone_in_light_and_dark,
    every_control_has_a_name,
    it_asks_nothing_of_the_network,
    it_works_from_a_static_server_by_keyboard_alone,
]


def main():
    passed = failed = 0
    with Browser(PAGE.as_uri(), before=(HERE / "fake_serial.js").read_text()) as browser:
        browser.wait(READY)
        for test in TESTS:
            name = f"web_{test.__name__}"
            if not any(part in name for part in sys.argv[4:] or [""]):
                continue
            begun = time.monotonic()
            with tempfile.TemporaryDirectory() as folder:
                try:
                    fresh(browser)
                    test(browser, pathlib.Path(folder))
                    print(f"ok {name} ({time.monotonic() - begun:.1f} s)", flush=True)
                    passed += 1
                except Exception as error:  # noqa: BLE001
                    print(f"FAILED {name}: {type(error).__name__}: {error}", file=sys.stderr, flush=True)
                    failed += 1
                    browser.go(PAGE.as_uri())
                    browser.wait(READY)
    print(f"web: {passed} passed, {failed} failed")
    return failed


sys.exit(min(main(), 1))
