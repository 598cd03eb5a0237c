"""Table d: main paths. An ordinary motor of other constants than the handout's, and the virtual board with each effect of the catalogue."""

from .generated import chosen, motor_file, recording
from .judge import costs, judge, probabilities, share
from .motors import believed, motor, reversing
from .program import WORK

NAME = "d"
TITLE = "main paths: an ordinary motor, and `lab --board` with each effect"
ORDINARY = {
    "gear12v": motor(12.0, 15.0, 5.5, 0.06, 0.07, 0.08, 1320.0),
    "small6v": motor(6.0, 40.0, 3.0, 0.03, 0.10, 0.05, 360.0),
    "large24v": motor(24.0, 30.0, 1.4, 0.10, 0.04, 0.10, 4000.0),
}
SAMPLE_TIME_S = 0.005
# How far a guess is off, one sigma; it states no tolerance.
GUESS = 0.25
# What is handed over: the runs, and whether with a motor file.
PATHS = {
    "two steps, guessed motor file": (("step1", "step2"), True),
    "two steps, no motor file": (("step1", "step2"), False),
    "two steps and reversing, guessed motor file": (("step1", "step2", "reversing"), True),
    "two steps and reversing, no motor file": (("step1", "step2", "reversing"), False),
}
STEP_S = 2.5
BOARD = {
    "right or in class": ("right", "in class"),
    "right, in class or as parameters": ("right", "in class", "as parameters"),
    "said that no effect is present": ("missed",),
}
REVERSING_S = 8.0


def recordings():
    found = {}
    for k, (name, true) in enumerate(ORDINARY.items()):
        volts = true["supply_v"]
        for level, step in ((volts / 2, "step1"), (volts, "step2")):
            found[f"{name}/{step}.csv"] = recording(true, [[0.0, 0.3], [level, STEP_S]], SAMPLE_TIME_S, 100 * k + len(found), protocol="step")
        found[f"{name}/reversing.csv"] = recording(true, reversing(volts, REVERSING_S), SAMPLE_TIME_S, 100 * k + len(found))
    return found


def as_log(run, log):
    """A run file as another program's log has it: time in ms, command in V, counts."""
    rows = [line.split(",") for line in run.read_text().splitlines() if not line.startswith("#")]
    names = {name: k for k, name in enumerate(rows[0])}
    lines = ["time_ms,voltage_v,counts"]
    lines += [f"{1000 * float(row[names['t_s']]):.3f},{row[names['command_v']]},{row[names['counts']]}" for row in rows[1:]]
    log.write_text("\n".join(lines) + "\n")


def cases(asked, program):
    folder = chosen("paths", recordings())
    done = []
    for k, (name, true) in enumerate(ORDINARY.items()):
        (folder / name / "motor.toml").write_text(motor_file(believed(true, GUESS, 17 + k)))
        if asked.tenth is None or k == asked.tenth % len(ORDINARY):
            for path in PATHS:
                done.append((f"d/{name}/{path}", lambda program, a=(folder / name, name, path): of_path(program, *a)))
    document = program.run(["effects", "--json"], WORK).document or {}
    effects = [one["effect"] for one in document.get("effects", [])]
    for k, effect in enumerate(effects):
        if asked.tenth is None or k % 10 == asked.tenth:
            done.append((f"d/lab/{effect}", lambda program, effect=effect: of_board(program, effect)))
    return done


def of_path(program, folder, name, path):
    """The runs are imported from logs, as a user has them: so no motor is known where no file says one."""
    runs, with_file = PATHS[path]
    work = WORK / "paths" / program.digest / name
    work.mkdir(parents=True, exist_ok=True)
    true = ORDINARY[name]
    for run in runs:
        as_log(folder / f"{run}.csv", work / f"{run}.log.csv")
        known = ["--counts-per-rev", f"{true['counts_per_rev']:g}", "--supply", f"{true['supply_v']:g}"]
        answer = program.run(["import", f"{run}.log.csv", *known, "-o", f"{run}.csv", "--force", "--json"], work)
        if answer.failure:
            raise RuntimeError(f"import of {run}: {answer.failure}")
    (work / "motor.toml").write_text((folder / "motor.toml").read_text())
    answer = program.diagnose(f"d/{name}/{path}", work, [f"{run}.csv" for run in runs], ["--motor", "motor.toml"] if with_file else [])
    case = judge(f"d/{name}/{path}", [], "none", answer)
    return case, case.row() | {"path": path}


def of_board(program, effect):
    """`lab --board effect=...` records two steps from a virtual board; they are diagnosed as lab does it, without a motor file."""
    work = WORK / "lab" / program.digest / effect
    work.mkdir(parents=True, exist_ok=True)
    runs = ["virtual-step30.csv", "virtual-step3.csv"]
    # Arrival times differ from recording to recording, so what was recorded once is kept as what was asked once is.
    if program.afresh or not (work / "index.html").exists():
        recorded = program.run(["lab", "--board", f"effect={effect}&seed=7", "--no-diagnosis", "-o", ".", "--force", "--json"], work)
        if recorded.failure:
            case = judge(f"d/lab/{effect}", [effect], "single", recorded)
            return case, case.row() | {"path": "lab --board"}
    answer = program.diagnose(f"d/lab/{effect}", work, runs)
    case = judge(f"d/lab/{effect}", [effect], "single", answer)
    return case, case.row() | {"path": "lab --board"}


def figures(done):
    ordinary = [case for case, row in done if row["path"] in PATHS]
    board = [case for case, row in done if row["path"] == "lab --board"]
    found = {"ordinary motors: no effect named": share(sum(case.verdict in ("no_gap", "parameters") for case in ordinary), len(ordinary))}
    for path in PATHS:
        of_path = [case for case, row in done if row["path"] == path]
        found[f"ordinary motors, {path}"] = share(sum(case.verdict in ("no_gap", "parameters") for case in of_path), len(of_path))
    for title, words in BOARD.items():
        found[f"lab --board: {title}"] = share(sum(case.word in words for case in board), len(board))
    return found | probabilities([case for case, _ in done]) | costs([case for case, _ in done])


def line(row):
    return f"{row['word']}; {row['said']}; {row['cpu_s']:.1f} s"
