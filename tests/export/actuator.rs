//! The motor with its effects as a C and as a Python function, against the simulator.

use std::path::Path;
use std::process::Command;

use crate::actuator_cases::{cases, compare};
use crate::support;
use crate::support::command::run;

/// Reads commands and writes the encoder's angle after each step.
const C_CALLER: &str = "#include \"motor.c\"\n#include <stdio.h>\n\
int main(void) {\n    motor_state s;\n    double volts;\n    motor_start(&s);\n\
    while (scanf(\"%lf\", &volts) == 1) {\n        motor_step(&s, volts);\n\
        printf(\"%.17g\\n\", motor_encoder_angle(&s));\n    }\n    return 0;\n}\n";

#[test]
fn c_agrees_with_the_simulator() {
    let directory = tempfile::tempdir().expect("a folder");
    let cases = cases(directory.path(), 0.1, &["c", "-o", "motor.c"]);
    for case in &cases {
        std::fs::write(case.folder.join("caller.c"), C_CALLER).expect("a program");
        let strict = [
            "-std=c99", "-Wall", "-Wextra", "-Werror", "-O1", "-o", "caller", "caller.c", "-lm",
        ];
        let compiled = Command::new("cc")
            .args(strict)
            .current_dir(&case.folder)
            .output();
        let Ok(compiled) = compiled else {
            support::skip(
                "export::actuator::c_agrees_with_the_simulator",
                "needs a C compiler, cc",
            );
            return;
        };
        assert!(
            compiled.status.success(),
            "{}",
            String::from_utf8_lossy(&compiled.stderr)
        );
        let commands = std::fs::File::open(case.folder.join("commands.txt")).expect("commands");
        let ran = Command::new(case.folder.join("caller"))
            .stdin(commands)
            .output()
            .expect("it runs");
        std::fs::write(case.folder.join("angles.txt"), ran.stdout).expect("angles");
    }
    compare(&cases);
}

/// The same for the Python modules in all folders of its working directory.
const PYTHON_CALLER: &str = "import glob, runpy\n\
for folder in glob.glob('motor_*'):\n\
\x20   motor = runpy.run_path(folder + '/motor.py')\n\
\x20   state = motor['State']()\n\
\x20   with open(folder + '/commands.txt') as commands, open(folder + '/angles.txt', 'w') as angles:\n\
\x20       for volts in commands:\n\
\x20           motor['step'](state, float(volts))\n\
\x20           print(repr(state.encoder_angle_rad), file=angles)\n";

#[test]
fn python_agrees_with_the_simulator() {
    let directory = tempfile::tempdir().expect("a folder");
    let cases = cases(directory.path(), 0.1, &["python", "-o", "motor.py"]);
    if !python(PYTHON_CALLER, directory.path()) {
        support::skip(
            "export::actuator::python_agrees_with_the_simulator",
            "needs python3",
        );
        return;
    }
    compare(&cases);
}

/// Runs a Python script; returns whether there is a Python.
fn python(script: &str, directory: &Path) -> bool {
    let ran = Command::new("python3")
        .args(["-c", script])
        .current_dir(directory)
        .output();
    let Ok(ran) = ran else { return false };
    assert!(
        ran.status.success(),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    true
}

/// A load below friction causes no motion, and the returned torque balances it; a larger one turns the motor.
const LOADED: &str = "import runpy\n\
motor = runpy.run_path('motor.py')\n\
for load, moves in ((0.019, False), (0.021, True), (-0.021, True)):\n\
\x20   state = motor['State']()\n\
\x20   state.load_nm = load\n\
\x20   torques = [motor['step'](state, 0.0) for _ in range(100)]\n\
\x20   assert (state.angle_rad * load > 0) == moves, (load, state.angle_rad)\n\
\x20   assert moves or all(torque == -load for torque in torques), torques\n";

#[test]
fn friction_holds_an_external_load() {
    let directory = tempfile::tempdir().expect("a folder");
    let exported = run(directory.path(), &["export", "python", "-o", "motor.py"]);
    assert_eq!(exported.status, Some(0), "{}", exported.messages);
    if !python(LOADED, directory.path()) {
        support::skip(
            "export::actuator::friction_holds_an_external_load",
            "needs python3",
        );
    }
}

#[test]
fn effects_of_the_recording_are_named() {
    let directory = tempfile::tempdir().expect("a folder");
    let motor = "[effects.stribeck]\n[effects.missed_counts]\n[effects.clock_error]\n[effects.command_offset]\n";
    std::fs::write(directory.path().join("motor.toml"), motor).expect("a motor file");
    for (format, file) in [
        ("c", "motor.c"),
        ("python", "motor.py"),
        ("octave", "motor_step.m"),
        ("isaac-lab", "motor_isaac.py"),
    ] {
        let asked = [
            "export",
            format,
            "--motor",
            "motor.toml",
            "-o",
            file,
            "--json",
        ];
        let exported = run(directory.path(), &asked);
        assert_eq!(exported.status, Some(0), "{}", exported.messages);
        let document: serde_json::Value = serde_json::from_str(&exported.output).expect("JSON");
        assert_eq!(document["effects"], serde_json::json!(["stribeck"]));
        let text = std::fs::read_to_string(directory.path().join(file)).expect("the file");
        let head: Vec<&str> = text.lines().take(7).collect();
        for id in ["command_offset", "missed_counts", "clock_error"] {
            let named = |effect: &serde_json::Value| effect["effect"] == id;
            assert!(
                document["not_part"]
                    .as_array()
                    .is_some_and(|effects| effects.iter().any(named))
            );
            assert!(
                head.iter()
                    .any(|line| line.contains(&format!("NOT IN IT: {id}"))),
                "{head:?}"
            );
            assert!(exported.messages.contains(id));
        }
        // The command replaces its own file, but not another one.
        assert_eq!(run(directory.path(), &asked).status, Some(0));
        std::fs::write(directory.path().join(file), "mine\n").expect("a file");
        assert_eq!(run(directory.path(), &asked).status, Some(2));
    }
}

#[test]
fn an_unusable_time_step_is_refused() {
    let directory = tempfile::tempdir().expect("a folder");
    let motor = "[effects.transport_delay]\ndelay_s = 0.2\n";
    std::fs::write(directory.path().join("motor.toml"), motor).expect("a motor file");
    let asked = [
        "export",
        "c",
        "--motor",
        "motor.toml",
        "--step-time",
        "0.000001",
    ];
    let refused = run(directory.path(), &asked);
    assert_eq!(refused.status, Some(2));
    assert!(
        refused.messages.contains("hint: --step-time"),
        "{}",
        refused.messages
    );
    for step in ["0", "-1", "nan", "2", "x"] {
        let refused = run(
            directory.path(),
            &["export", "c", &format!("--step-time={step}")],
        );
        assert_eq!(refused.status, Some(2), "{step}");
        assert!(refused.messages.contains("hint:"), "{}", refused.messages);
    }
}
