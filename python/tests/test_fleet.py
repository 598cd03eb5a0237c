"""The queries of the fleet page, as a user copies them, in DuckDB over the tables that stand beside it."""

import html
import json
import re

import duckdb
import pytest
from conftest import document, program

import motorlab as ml


@pytest.fixture(scope="module")
def documents(tmp_path_factory):
    """Six diagnoses of three units on two dates, and one invalid document."""
    folder = tmp_path_factory.mktemp("documents")
    frictions = {"A": 1.0, "B": 1.2, "C": 2.0}
    for unit, factor in frictions.items():
        for day in (1, 2):
            motor = ml.Motor()
            motor.coulomb_friction_nm *= factor + 0.05 * day
            run = _run(folder, motor, f"{unit}_2026-03-0{day}")
            found = document("diagnose", run, "--threads", 1)
            (folder / f"{unit}_2026-03-0{day}.json").write_text(json.dumps(found))
    short = _run(folder, ml.Motor(), "D_2026-03-01", duration=0.02)
    (folder / "D_2026-03-01.json").write_text(json.dumps(document("diagnose", short)))
    return folder


def _run(folder, motor, name, duration=2):
    motor.save(folder / f"{name}.toml")
    path = folder / f"{name}.csv"
    words = ("--motor", folder / f"{name}.toml", "--profile", "reversing", "--ts", "0.01", "--duration", duration)
    made = program("simulate", *words, "-o", path)
    assert made.returncode == 0, made.stderr
    return path


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_every_query_of_the_fleet_page_runs_in_duckdb(documents, tmp_path, monkeypatch, ending):
    monkeypatch.chdir(tmp_path)
    tables = ("-o", f"fleet.{ending}", "--causes", f"causes.{ending}", "--numbers", f"numbers.{ending}")
    done = program("tabulate", documents, *tables, "--html", "fleet.html")
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "fleet.html").read_text()
    queries = [html.unescape(text) for text in re.findall(r"<pre>(.*?)</pre>", page, re.S) if "SELECT" in text]
    assert len(queries) == 5
    verdicts, causes, apart, over_time, unusable = (duckdb.sql(query).df() for query in queries)
    assert verdicts["diagnoses"].sum() == 7 and {"bad_recording"} < set(verdicts["verdict"])
    assert causes["probability"].between(0, 1).all() and causes["units"].max() == 3
    assert set(apart["unit"]) <= set("ABC") and apart["z"].abs().is_monotonic_decreasing
    friction = apart[apart["name"] == "coulomb_friction_nm"].set_index("unit")
    assert friction["value"].idxmax() == "C"
    assert list(over_time["unit"]) == list("AABBCC") and (over_time["lo95"] <= over_time["hi95"]).all()
    assert list(unusable["document"].str.contains("D_2026-03-01")) == [True]
