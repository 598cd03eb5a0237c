//! Motors and runs in other programs' formats, read by those programs if they are installed.

use std::path::Path;
use std::process::Command;

use crate::support;
use crate::support::command::{RunFile, run};

/// A motor file with one effect that MuJoCo and URDF can express and one that they cannot.
const WITH_EFFECTS: &str = "resistance_ohm = 7.5\n[effects.coulomb_friction]\ntorque_nm = 0.031\n\
[effects.cogging]\ntorque_nm = 0.01\ncycles_per_rev = 12\nphase_rad = 0.3\n";

fn directory() -> tempfile::TempDir {
    let directory = tempfile::tempdir().expect("a folder");
    std::fs::write(directory.path().join("motor.toml"), WITH_EFFECTS).expect("a motor file");
    directory
}

/// Output of a program, or `None` if it is not installed.
fn said(program: &str, arguments: &[&str], directory: &Path) -> Option<String> {
    let output = Command::new(program)
        .args(arguments)
        .current_dir(directory)
        .output()
        .ok()?;
    assert!(
        output.status.success(),
        "{program}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace()
        .map(|word| word.parse().unwrap_or_else(|_| panic!("no number: {word}")))
        .collect()
}

#[test]
fn octave_runs_the_parameters_and_loads_the_run() {
    let directory = directory();
    let folder = directory.path();
    let simulated = run(
        folder,
        &[
            "simulate",
            "--ts",
            "0.003",
            "--duration",
            "0.6",
            "--profile",
            "reversing",
            "-o",
            "run.csv",
        ],
    );
    assert_eq!(simulated.status, Some(0), "{}", simulated.messages);
    let exported = run(
        folder,
        &[
            "export",
            "matlab",
            "--motor",
            "motor.toml",
            "--run",
            "run.csv",
            "-o",
            "matlab",
        ],
    );
    assert_eq!(exported.status, Some(0), "{}", exported.messages);
    let script = "Motor_Parameters; \
        printf('%.17g ', Rm, Kb, Kt, Bm, Lm, Jm, Tf, encoder_counts, Vsupply, RADSEC2RPM, COUNTS2RAD, \
        effects.cogging.torque_nm, effects.coulomb_friction.torque_nm); \
        load('run.mat'); printf('%.17g ', TS, rows(t_s), columns(t_s), t_s, command_v, counts, velocity_rad_s);";
    let Some(text) = said(
        "octave-cli",
        &["--no-init-file", "--quiet", "--eval", script],
        &folder.join("matlab"),
    ) else {
        support::skip(
            "export::octave_runs_the_parameters_and_loads_the_run",
            "needs octave-cli (Debian package octave)",
        );
        return;
    };
    let read = numbers(&text);
    let file = RunFile::read(&folder.join("run.csv"));
    let samples = file.rows.len();
    let turn = std::f64::consts::TAU;
    let mut expected = vec![
        7.5,
        0.7,
        0.7,
        0.01,
        0.004,
        0.002,
        0.02,
        720.0,
        4.5,
        60.0 / turn,
        turn / 720.0,
        0.01,
        0.031,
        0.003,
        samples as f64,
        1.0,
    ];
    for name in ["t_s", "command_v", "counts", "velocity_rad_s"] {
        expected.extend(file.column(name));
    }
    assert_eq!(read.len(), expected.len());
    for (k, (read, expected)) in read.iter().zip(&expected).enumerate() {
        // Octave evaluates 2 pi itself; everything else reads back bitwise.
        let same = read == expected || (read.is_nan() && expected.is_nan());
        assert!(
            same || (read / expected - 1.0).abs() < 1e-15,
            "number {k}: {read}, {expected}"
        );
    }
    assert!(samples > 150);
}

#[test]
fn inexpressible_effects_are_named() {
    let directory = directory();
    for format in ["mujoco", "urdf"] {
        let file = format!("{format}.xml");
        let asked = ["export", format, "--motor", "motor.toml", "-o", &file];
        let refused = run(directory.path(), &asked);
        assert_eq!(refused.status, Some(2));
        assert!(
            refused
                .messages
                .contains("'cogging' (tau_m + torque_nm sin"),
            "{}",
            refused.messages
        );
        // Both formats have friction.
        let (_, why) = refused.messages.split_once("error: ").expect("why");
        assert!(!why.contains("coulomb_friction"), "{why}");
        assert!(!directory.path().join(&file).exists());
        let left_out = run(directory.path(), &[&asked[..], &["--leave-out"]].concat());
        assert_eq!(left_out.status, Some(0), "{}", left_out.messages);
        let text = std::fs::read_to_string(directory.path().join(&file)).expect("the file");
        assert!(text.contains("LEFT OUT") && text.contains("cogging"));
        assert!(text.contains("\"0.031\""), "{text}");
    }
}

#[test]
fn json_holds_every_parameter_and_effect_with_its_unit() {
    let directory = directory();
    let exported = run(
        directory.path(),
        &["export", "json", "--motor", "motor.toml"],
    );
    assert_eq!(exported.status, Some(0), "{}", exported.messages);
    let document: serde_json::Value = serde_json::from_str(&exported.output).expect("JSON");
    assert_eq!(document["parameters"]["resistance_ohm"]["value"], 7.5);
    assert_eq!(document["parameters"]["resistance_ohm"]["unit"], "ohm");
    let cogging = &document["effects"]["cogging"];
    assert_eq!(cogging["parameters"]["cycles_per_rev"]["value"], 12.0);
    assert!(cogging["equation"].is_string());
}

/// A step of the handout's motor in MuJoCo, in steps of 0.1 ms: the speeds every 10 ms.
const IN_MUJOCO: &str = "import mujoco, sys\n\
m = mujoco.MjModel.from_xml_path(sys.argv[1]); m.opt.timestep = 1e-4\n\
d = mujoco.MjData(m); d.ctrl[0] = 4.5\n\
for k in range(3000):\n    mujoco.mj_step(m, d)\n    if k % 100 == 99: print(d.qvel[0])\n";

#[test]
fn mujoco_follows_the_closed_form() {
    let directory = directory();
    let exported = run(directory.path(), &["export", "mujoco", "-o", "motor.xml"]);
    assert_eq!(exported.status, Some(0), "{}", exported.messages);
    let python = std::env::var("MOTORLAB_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    if said(
        &python,
        &[
            "-c",
            "import importlib.util as u; print(int(u.find_spec('mujoco') is not None))",
        ],
        directory.path(),
    )
    .is_none_or(|text| text.trim() != "1")
    {
        support::skip(
            "export::mujoco_follows_the_closed_form",
            "needs Python with the package mujoco (MOTORLAB_PYTHON names the interpreter)",
        );
        return;
    }
    let text =
        said(&python, &["-c", IN_MUJOCO, "motor.xml"], directory.path()).expect("MuJoCo runs");
    let speeds = numbers(&text);
    assert_eq!(speeds.len(), 30);
    // First order with Coulomb friction: w = w_inf (1 - exp(-t / T)).
    let damping = 0.01 + 0.7 * 0.7 / 10.0;
    let (steady, time_constant_s) = ((0.7 * 4.5 / 10.0 - 0.02) / damping, 0.002 / damping);
    for (k, speed) in speeds.iter().enumerate() {
        let t_s = 0.01 * (k + 1) as f64;
        let expected = steady * -f64::exp_m1(-t_s / time_constant_s);
        assert!(
            (speed - expected).abs() < 2e-3 * steady,
            "{t_s} s: {speed}, {expected}"
        );
    }
}
