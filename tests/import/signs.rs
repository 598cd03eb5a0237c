//! Commands without a sign for a shaft that turns in both directions, numbers that are ten times their quantity, and
//! numbers with a spreadsheet's minus sign.

use crate::support::foreign_logs::{Truth, asked, counts, imported, log, near};

const FLAGS: [&str; 4] = ["--counts-per-rev", "720", "--supply", "12"];

fn written(truth: &Truth, name: &str, command: impl Fn(i64) -> String) -> String {
    let ms = |k: usize| truth.ms(k).to_string();
    let command = |k: usize| command(truth.pwm[k]);
    let position = |k: usize| truth.counts[k].to_string();
    let names = format!("time_ms,{name},counts");
    log(&names, truth.rows(), &[&ms, &command, &position])
}

/// Locked antiphase: half of full drive is standstill.
#[test]
fn a_command_around_half_scale_is_centred() {
    let truth = Truth::steps(0.01, 300);
    for (name, full) in [("pwm_255", 255.0), ("duty_percent", 100.0), ("duty", 1.0)] {
        let text = written(&truth, name, |pwm| {
            let level = full * (0.5 + 0.5 * pwm as f64 / 255.0);
            format!("{level:.4}")
        });
        let (file, said) = imported("log.csv", &text, &FLAGS);
        assert!(
            said.contains("is standstill, as the motion shows"),
            "{said}"
        );
        near(&file.column("command_v"), &truth.commands(), 0.01);
        assert_eq!(counts(&file), truth.counts);
    }
}

/// A magnitude does not determine the direction; a positive command of a motor that turns in one direction is no
/// magnitude.
#[test]
fn a_magnitude_without_its_direction_is_reported() {
    let truth = Truth::steps(0.01, 300);
    let text = written(&truth, "pwm_255", |pwm| pwm.abs().to_string());
    let (_, said) = imported("log.csv", &text, &FLAGS);
    assert!(
        said.contains("the command's direction is not in it"),
        "{said}"
    );
    assert!(said.contains("hint: --direction COLUMN"), "{said}");
    let one_way = Truth::of(0.01, (0..300).map(|k| [0, 200, 80][k / 100]));
    let text = written(&one_way, "pwm_255", |pwm| pwm.to_string());
    let (file, said) = imported("log.csv", &text, &FLAGS);
    assert!(
        !said.contains("direction") && !said.contains("standstill"),
        "{said}"
    );
    near(&file.column("command_v"), &one_way.commands(), 1e-6);
}

#[test]
fn a_name_with_a_factor_of_ten_is_no_unit() {
    let truth = Truth::steps(0.01, 300);
    let text = truth.rpm_log("time_ms,pwm,rpm_x10");
    let said = asked("log.csv", &text, &FLAGS);
    assert!(
        said.contains("`rpm_x10`: by its name its numbers are 10 times"),
        "{said}"
    );
    assert!(said.contains("scale = 0.1"), "{said}");
}

#[test]
fn the_minus_sign_of_a_spreadsheet_is_recognized() {
    let truth = Truth::steps(0.01, 300);
    let text = truth.counts_log().replace('-', "\u{2212}");
    let (file, _) = imported("log.csv", &text, &FLAGS);
    assert_eq!(counts(&file), truth.counts);
    near(&file.column("command_v"), &truth.commands(), 1e-6);
}

#[test]
fn a_voltage_that_never_changes_is_no_command_of_a_shaft_that_turns_both_ways() {
    let truth = Truth::steps(0.01, 300);
    let ms = |k: usize| truth.ms(k).to_string();
    let turned = |k: usize| truth.counts[k].to_string();
    let constant = |_| "24.0".to_owned();
    let text = log(
        "time_ms,voltage,counts",
        truth.rows(),
        &[&ms, &constant, &turned],
    );
    let said = asked("log.csv", &text, &FLAGS);
    assert!(
        said.contains("`voltage` is 24 in every row while the shaft turns both ways"),
        "{said}"
    );
    assert!(said.contains("--command COLUMN:UNIT"), "{said}");
}

/// Degrees in a row, and a speed under the name of a position.
#[test]
fn a_speed_is_not_silently_read_as_a_position() {
    let truth = Truth::steps(0.01, 300);
    let ms = |k: usize| truth.ms(k).to_string();
    let volts = |k: usize| format!("{:.6}", truth.volts(k));
    let step = |k: usize| {
        let counts = truth.counts[k] - truth.counts[k.saturating_sub(1)];
        (counts as f64 / 2.0).to_string()
    };
    let text = log(
        "time_ms,voltage,deg_per_sample",
        truth.rows(),
        &[&ms, &volts, &step],
    );
    let (file, said) = imported("log.csv", &text, &["--counts-per-rev", "720"]);
    assert!(said.contains("since the row before"), "{said}");
    assert_eq!(counts(&file), truth.counts);
    let text = text.replace("deg_per_sample", "angle_deg");
    let (_, said) = imported("log.csv", &text, &["--counts-per-rev", "720"]);
    assert!(
        said.contains("follows the command as a speed does"),
        "{said}"
    );
}
