//! The motor with its effects in Octave, in MuJoCo and on torch, against the simulator.

use std::path::Path;
use std::process::Command;

use crate::actuator_cases::{cases, compare};
use crate::support;

/// Duration of each command for interpreted programs, in s: a tenth of a second would take minutes. With 20 ms the
/// simulator misses two events within one of its steps (docs/method/simulation.md).
const SHORT_HOLD_S: f64 = 0.03;

/// In every folder: the initial state from the file's first lines, then a step for each command.
const OCTAVE_CALLER: &str = "\
folders = glob('motor_*');
for n = 1:numel(folders)
  cd(folders{n});
  text = fileread('motor_step.m');
  found = regexp(text, 's = struct\\([^\\n]*\\);', 'match');
  eval(found{1});
  found = regexp(text, 'encoder sees s\\.y\\((\\d+)\\)', 'tokens');
  at = str2double(found{1}{1});
  commands = load('commands.txt');
  file = fopen('angles.txt', 'w');
  for k = 1:numel(commands)
    [torque, s] = motor_step(s, commands(k));
    fprintf(file, '%.17g\\n', s.y(at));
  end
  fclose(file);
  cd('..');
  clear motor_step
end
";

#[test]
fn octave_agrees_with_the_simulator() {
    let directory = tempfile::tempdir().expect("a folder");
    let cases = cases(
        directory.path(),
        SHORT_HOLD_S,
        &["octave", "-o", "motor_step.m"],
    );
    std::fs::write(directory.path().join("caller.m"), OCTAVE_CALLER).expect("a script");
    let arguments = ["--no-init-file", "--quiet", "caller.m"];
    if !ran("octave-cli", &arguments, directory.path()) {
        support::skip(
            "export::actuator_programs::octave_agrees_with_the_simulator",
            "needs octave-cli (Debian package octave)",
        );
        return;
    }
    compare(&cases);
}

/// MuJoCo integrates the joint; an encoder on the motor side is known to the module only. At the end the joint has
/// the angle of the module's output shaft.
const MUJOCO_CALLER: &str = "import glob, runpy, mujoco\n\
for folder in glob.glob('motor_*'):\n\
\x20   model = mujoco.MjModel.from_xml_path(folder + '/motor.xml')\n\
\x20   data = mujoco.MjData(model)\n\
\x20   motor = runpy.run_path(folder + '/motor.py')\n\
\x20   (actuator,) = motor['install'](model).values()\n\
\x20   with open(folder + '/commands.txt') as commands, open(folder + '/angles.txt', 'w') as angles:\n\
\x20       for volts in commands:\n\
\x20           data.ctrl[0] = float(volts)\n\
\x20           mujoco.mj_step(model, data)\n\
\x20           assert abs(data.qpos[0] - actuator.state.angle_rad) < 1e-6, folder\n\
\x20           print(repr(actuator.state.encoder_angle_rad), file=angles)\n\
\x20   motor['remove']()\n";

#[test]
fn mujoco_agrees_with_the_simulator() {
    let directory = tempfile::tempdir().expect("a folder");
    let files = ["mujoco", "-o", "motor.xml", "--callback", "motor.py"];
    let cases = cases(directory.path(), 0.1, &files);
    if python_with(
        "mujoco",
        "actuator_programs::mujoco_agrees_with_the_simulator",
        MUJOCO_CALLER,
        directory.path(),
    ) {
        compare(&cases);
    }
}

/// An external torque that friction holds, and one that it does not: as a load in the simulator.
const MUJOCO_LOADED: &str = "import runpy, mujoco\n\
model = mujoco.MjModel.from_xml_path('motor.xml')\n\
data = mujoco.MjData(model)\n\
motor = runpy.run_path('motor.py')\n\
motor['install'](model)\n\
data.qfrc_applied[0] = 0.018\n\
for _ in range(500): mujoco.mj_step(model, data)\n\
held = data.qpos[0]\n\
assert abs(held) < 1e-4, held\n\
data.qfrc_applied[0] = 0.04\n\
for _ in range(1000): mujoco.mj_step(model, data)\n\
speed = (0.04 - 0.02) / (0.01 + 0.7 * 0.7 / 10.0)\n\
assert abs(data.qvel[0] / speed - 1.0) < 1e-3, (data.qvel[0], speed)\n\
mujoco.mj_resetData(model, data)\n\
for _ in range(10): mujoco.mj_step(model, data)\n\
assert data.qpos[0] == 0.0, data.qpos[0]\n";

#[test]
fn in_mujoco_friction_holds_an_external_load() {
    let directory = tempfile::tempdir().expect("a folder");
    let asked = [
        "export",
        "mujoco",
        "-o",
        "motor.xml",
        "--callback",
        "motor.py",
    ];
    assert_eq!(
        support::command::run(directory.path(), &asked).status,
        Some(0)
    );
    python_with(
        "mujoco",
        "actuator_programs::in_mujoco_friction_holds_an_external_load",
        MUJOCO_LOADED,
        directory.path(),
    );
}

/// A joint with inertia alone, driven by the class as in Isaac Lab: two environments, the second with time-reversed
/// voltages and a reset in between, which must not affect the first.
const TORCH_CALLER: &str = "import glob, runpy, types, torch\n\
torch.set_num_threads(1)\n\
for folder in glob.glob('motor_*'):\n\
\x20   motor = runpy.run_path(folder + '/motor.py')\n\
\x20   actuator = motor['Motor'](None, ['joint'], slice(None), 2, 'cpu')\n\
\x20   angle, speed = torch.zeros(2, 1, dtype=torch.float64), torch.zeros(2, 1, dtype=torch.float64)\n\
\x20   commands = [float(line) for line in open(folder + '/commands.txt')]\n\
\x20   with open(folder + '/angles.txt', 'w') as angles:\n\
\x20       for k, (volts, other) in enumerate(zip(commands, reversed(commands))):\n\
\x20           if k == 50:\n\
\x20               angle[1] = speed[1] = 0.0\n\
\x20               actuator.reset([1])\n\
\x20           action = types.SimpleNamespace(joint_efforts=torch.tensor([[volts], [other]], dtype=torch.float64))\n\
\x20           torque = actuator.compute(action, angle, speed).joint_efforts\n\
\x20           speed = speed + motor['STEP_S'] * torque / motor['OUTPUT_INERTIA_KG_M2']\n\
\x20           angle = angle + motor['STEP_S'] * speed\n\
\x20           assert abs(float(angle[0] - actuator.angle_rad[0])) < 1e-6, folder\n\
\x20           print(repr(float(actuator.encoder_angle_rad[0])), file=angles)\n";

#[test]
fn torch_agrees_with_the_simulator() {
    let directory = tempfile::tempdir().expect("a folder");
    let cases = cases(
        directory.path(),
        SHORT_HOLD_S,
        &["isaac-lab", "-o", "motor.py"],
    );
    if python_with(
        "torch",
        "actuator_programs::torch_agrees_with_the_simulator",
        TORCH_CALLER,
        directory.path(),
    ) {
        compare(&cases);
    }
}

/// Runs a script in a Python with this package; without one the test is skipped.
fn python_with(package: &str, test: &str, script: &str, directory: &Path) -> bool {
    let named = std::env::var("MOTORLAB_PYTHON").ok();
    let own = concat!(env!("CARGO_MANIFEST_DIR"), "/target/export-venv/bin/python");
    let has = format!("import {package}");
    for python in [named.as_deref(), Some(own), Some("python3")]
        .into_iter()
        .flatten()
    {
        let found = Command::new(python).args(["-c", &has]).output();
        if found.is_ok_and(|found| found.status.success()) {
            return ran(python, &["-c", script], directory);
        }
    }
    let needs =
        format!("needs Python with the package {package} (MOTORLAB_PYTHON names the interpreter)");
    support::skip(&format!("export::{test}"), &needs);
    false
}

/// Runs a program to its end; returns whether it is installed.
fn ran(program: &str, arguments: &[&str], directory: &Path) -> bool {
    let ran = Command::new(program)
        .args(arguments)
        .current_dir(directory)
        .output();
    let Ok(ran) = ran else { return false };
    assert!(
        ran.status.success(),
        "{program}: {}",
        String::from_utf8_lossy(&ran.stderr)
    );
    true
}
