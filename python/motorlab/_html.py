"""Tables for notebooks; whatever a file put into a text is shown, never run."""

from __future__ import annotations

from html import escape
from typing import Any, Sequence


def table(names: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """A table of texts."""
    head = "".join(f"<th>{escape(str(name))}</th>" for name in names)
    body = "".join("<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def paragraph(text: str, *, strong: bool = False) -> str:
    """A paragraph of text."""
    inside = f"<strong>{escape(text)}</strong>" if strong else escape(text)
    return f"<p>{inside}</p>"
