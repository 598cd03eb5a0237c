"""Tables side by side: this program's figures and the last committed ones."""

import json
from pathlib import Path

from .judge import WORDS

COMMITTED = Path(__file__).resolve().parent / "committed"


def committed(selection):
    """The committed tables of the same selection (`full` or `tenth-N`), or nothing."""
    file = COMMITTED / f"{selection}.json"
    return json.loads(file.read_text()) if file.exists() else {"program": "none committed", "tables": {}}


def shown(value):
    """A figure: hits of so many, a number, a word."""
    if value is None:
        return "-"
    if isinstance(value, list):
        return f"{value[0]} of {value[1]}" + (f", {100 * value[0] / value[1]:.0f} %" if value[1] else "")
    return f"{value:.3f}" if isinstance(value, float) else str(value)


def table(name, found, before):
    """All of a table as lines of Markdown."""
    old = before.get(name, {})
    lines = [f"## Table {name}: {found['title']}", "", "| figure | this program | committed |", "| --- | --- | --- |"]
    lines += [f"| {key} | {shown(value)} | {shown(old.get('figures', {}).get(key))} |" for key, value in found["figures"].items()]
    lines.append("")
    if "words" in found:
        lines += ["| what is there | cases | " + " | ".join(WORDS) + " |", "| --- " * (len(WORDS) + 2) + "|"]
        for kind, (count, *of_words) in found["words"].items():
            lines.append(f"| {kind} | {count} | " + " | ".join(str(n or "") for n in of_words) + " |")
        lines.append("")
    for title, rows in found.get("reliability", {}).items():
        earlier = old.get("reliability", {}).get(title, {})
        lines.append(f"| {title} | how many | mean probability | share that is so | committed: how many, mean, share |")
        lines.append("| --- | --- | --- | --- | --- |")
        for tenth, (count, said, is_so) in rows.items():
            was = earlier.get(tenth)
            lines.append(f"| {tenth} | {count} | {said:.2f} | {is_so:.2f} | " + (f"{was[0]}, {was[1]:.2f}, {was[2]:.2f}" if was else "-") + " |")
        lines.append("")
    was = old.get("lines", {})
    if name == "b":
        changed = {case: text for case, text in found["lines"].items() if word_in(was.get(case, "")) != word_in(text) and case in was}
        lines.append(f"Cases that are judged differently: {len(changed)}")
        lines += [f"- {case}: {text}\n  committed: {was[case]}" for case, text in changed.items()]
        sure = [f"- {case}: {found['lines'][case]}" for case in found["wrong_and_sure"]]
        lines += ["", f"Wrong and sure: {len(sure)}", *sure, ""]
        return lines
    for case, text in found["lines"].items():
        lines.append(f"- {case}: {text}")
        if case in was and was[case] != text:
            lines.append(f"  committed: {was[case]}")
    return lines + [""]


def word_in(text):
    """How a case of table b is judged, from its line."""
    return text.split("): ")[-1].split(";")[0]
