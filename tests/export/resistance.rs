//! An assumed resistance is named in every output, and one measurement corrects it.

use std::path::Path;
use std::process::Command;

use motorlab::motor::Motor;

use crate::support;
use crate::support::command::run;

const ASSUMED: &str = "resistance_ohm = 10.0\nresistance_assumed = true\n\
[effects.coulomb_friction]\ntorque_nm = 0.031\n";

/// Format, further arguments, files.
const FORMATS: [(&str, &[&str], &[&str]); 8] = [
    ("matlab", &["-o", "m"], &["m/Motor_Parameters.m"]),
    ("mujoco", &["-o", "a.xml"], &["a.xml"]),
    (
        "mujoco",
        &["-o", "b.xml", "--callback", "b.py"],
        &["b.xml", "b.py"],
    ),
    ("urdf", &["-o", "a.urdf"], &["a.urdf"]),
    ("c", &["-o", "a.c"], &["a.c"]),
    ("python", &["-o", "a.py"], &["a.py"]),
    ("octave", &["-o", "a.m"], &["a.m"]),
    ("isaac-lab", &["-o", "c.py"], &["c.py"]),
];

fn directory(motor: &str) -> tempfile::TempDir {
    let directory = tempfile::tempdir().expect("a folder");
    std::fs::write(directory.path().join("motor.toml"), motor).expect("a motor file");
    directory
}

fn first_lines(directory: &Path, file: &str) -> String {
    let text = std::fs::read_to_string(directory.join(file)).expect("the file");
    text.lines().take(7).collect::<Vec<_>>().join("\n")
}

#[test]
fn every_file_states_its_assumptions_in_its_first_lines() {
    let directory = directory(ASSUMED);
    for (format, more, files) in FORMATS {
        let asked = [&["export", format, "--motor", "motor.toml", "--json"], more].concat();
        let exported = run(directory.path(), &asked);
        assert_eq!(exported.status, Some(0), "{}", exported.messages);
        let document: serde_json::Value = serde_json::from_str(&exported.output).expect("JSON");
        assert!(
            document["assumed"][0]
                .as_str()
                .is_some_and(|line| line.contains("R = 10 ohm")),
            "{document}"
        );
        for file in files {
            let head = first_lines(directory.path(), file);
            assert!(
                head.contains("ASSUMED: the resistance R = 10 ohm") && head.contains("ohmmeter"),
                "{file}: {head}"
            );
        }
        let measured = run(
            directory.path(),
            &[&asked[..], &["--resistance", "3.1"]].concat(),
        );
        assert_eq!(measured.status, Some(0), "{}", measured.messages);
        assert!(!measured.output.contains("assumed"), "{}", measured.output);
        for file in files {
            let head = first_lines(directory.path(), file);
            assert!(!head.contains("ASSUMED"), "{file}: {head}");
        }
    }
    let json = run(
        directory.path(),
        &[
            "export",
            "json",
            "--motor",
            "motor.toml",
            "--resistance",
            "5",
        ],
    );
    let document: serde_json::Value = serde_json::from_str(&json.output).expect("JSON");
    // Friction of 0.031 N m at 10 ohm is the same voltage as 0.062 N m at 5 ohm.
    assert_eq!(
        document["effects"]["coulomb_friction"]["parameters"]["torque_nm"]["value"],
        0.062
    );
    assert_eq!(document["parameters"]["resistance_ohm"]["value"], 5.0);
}

#[test]
fn a_resistance_stays_assumed_until_it_is_measured() {
    let directory = directory(ASSUMED);
    let shown = run(directory.path(), &["motor", "motor.toml"]);
    assert!(
        shown
            .output
            .starts_with("# ASSUMED: the resistance R = 10 ohm"),
        "{}",
        shown.output
    );
    let motor = Motor::from_toml(&shown.output).expect("a motor file");
    assert!(motor.resistance_assumed);
    let asked = [
        "motor",
        "motor.toml",
        "--resistance",
        "3.1",
        "-o",
        "measured.toml",
    ];
    assert_eq!(run(directory.path(), &asked).status, Some(0));
    let text =
        std::fs::read_to_string(directory.path().join("measured.toml")).expect("a motor file");
    assert!(
        !text.contains("assumed") && text.contains("resistance_ohm = 3.1"),
        "{text}"
    );
    for wrong in ["0", "-3", "nan", "1e9", "x"] {
        let refused = run(
            directory.path(),
            &["export", "c", &format!("--resistance={wrong}")],
        );
        assert_eq!(refused.status, Some(2), "{wrong}");
        assert!(refused.messages.contains("hint:"), "{}", refused.messages);
    }
    std::fs::write(
        directory.path().join("motor.toml"),
        "resistance_assumed = 3\n",
    )
    .expect("a motor file");
    let refused = run(directory.path(), &["motor", "motor.toml"]);
    assert!(
        refused.messages.contains("true or false"),
        "{}",
        refused.messages
    );
}

/// The angle after some steps of the modules with both resistances.
const MOVES: &str = "import runpy\n\
ends = []\n\
for name in ('assumed.py', 'measured.py'):\n\
\x20   motor = runpy.run_path(name)\n\
\x20   state = motor['State']()\n\
\x20   torque = [motor['step'](state, volts) for volts in [4.5] * 50 + [-2.0] * 50]\n\
\x20   ends.append((state.angle_rad, torque[0]))\n\
assert abs(ends[0][0] - ends[1][0]) < 1e-9 < abs(ends[0][0]), ends\n\
assert abs(ends[1][1] / ends[0][1] - 4.0) < 1e-6, ends\n";

#[test]
fn a_measured_resistance_changes_torques_and_no_motion() {
    let directory = directory(ASSUMED);
    for (file, more) in [
        ("assumed.py", &[][..]),
        ("measured.py", &["--resistance", "2.5"]),
    ] {
        let asked = [
            &["export", "python", "--motor", "motor.toml", "-o", file],
            more,
        ]
        .concat();
        assert_eq!(run(directory.path(), &asked).status, Some(0));
    }
    let ran = Command::new("python3")
        .args(["-c", MOVES])
        .current_dir(directory.path())
        .output();
    let Ok(ran) = ran else {
        let test = "export::resistance::a_measured_resistance_changes_torques_and_no_motion";
        support::skip(test, "needs python3");
        return;
    };
    assert!(
        ran.status.success(),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
}

#[test]
fn a_fit_of_voltage_and_counts_states_that_the_resistance_is_assumed() {
    let directory = directory(ASSUMED);
    let simulate = [
        "simulate",
        "--profile",
        "step",
        "--duration",
        "1",
        "--ts",
        "0.003",
        "-o",
        "run.csv",
    ];
    assert_eq!(run(directory.path(), &simulate).status, Some(0));
    let stated = directory.path().join("stated.toml");
    std::fs::write(&stated, Motor::default().to_toml()).expect("a motor file");
    for (motor, is_assumed) in [
        (None, true),
        (Some("motor.toml"), true),
        (Some("stated.toml"), false),
    ] {
        let mut asked = vec!["diagnose", "run.csv", "--model-out", "found.toml"];
        asked.extend(motor.into_iter().flat_map(|motor| ["--motor", motor]));
        let done = run(directory.path(), &asked);
        assert_eq!(done.status, Some(0), "{}", done.messages);
        let head = first_lines(directory.path(), "found.toml");
        assert_eq!(head.contains("ASSUMED"), is_assumed, "{motor:?}: {head}");
    }
}
