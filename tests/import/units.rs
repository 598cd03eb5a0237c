//! Units that a log leaves open or contradicts.

use crate::support::foreign_logs::{Truth, asked, counts, imported, log, proposed};

fn table(truth: &Truth, name: &str, cell: &dyn Fn(usize) -> String) -> String {
    let ms = |k: usize| truth.ms(k).to_string();
    let volts = |k: usize| format!("{:.6}", truth.volts(k));
    let names = format!("time_ms,voltage,{name}");
    log(&names, truth.rows(), &[&ms, &volts, cell])
}

#[test]
fn metres_a_second_ask_for_the_travel_with_the_rest() {
    let truth = Truth::steps(0.02, 300);
    let metres = |k: usize| {
        format!(
            "{:.4}",
            truth.rpm(k).parse::<f64>().expect("rpm") / 60.0 * 0.2
        )
    };
    for (name, flags) in [
        ("speed [m/s]", &[][..]),
        ("v [m/s]", &[][..]),
        ("wheel_speed_mps", &[][..]),
        ("v_m_s", &[][..]),
        ("velocity [cm/s]", &[][..]),
        ("v", &["--speed", "v:m/s"]),
    ] {
        let said = asked("log.csv", &table(&truth, name, &metres), flags);
        for flag in ["--m-per-rev METRES", "--counts-per-rev COUNTS"] {
            assert!(said.contains(flag), "{said}");
        }
    }
}

#[test]
fn columns_that_comments_name_by_their_numbers_have_names() {
    let truth = Truth::steps(0.02, 300);
    let mut text = "%% logfile from robot\n%  1    time 0.014 sec\n%  2  3 Motor voltage [V] left, right: 0.0 0.0\n\
                    %  4  5 Wheel velocity [rpm] left, right: 0.0 0.0\n"
        .to_owned();
    for k in truth.rows() {
        let (t_s, u, v) = (truth.t_s(k), truth.volts(k), truth.rpm(k));
        text.push_str(&format!("{t_s:.4} {u:.3} {u:.3} {v} {v} \n"));
    }
    let said = asked("log.txt", &text, &[]);
    assert!(said.contains("`Wheel velocity [rpm] left`"), "{said}");
    let (file, _) = imported("log.txt", &text, &["--speed", "4", "--command", "2:V"]);
    assert_eq!(counts(&file), truth.counts);
}

#[test]
fn a_position_whose_steps_are_whole_parts_of_a_turn_is_in_revolutions() {
    let truth = Truth::steps(0.01, 300);
    let turns = |k: usize| format!("{:.7}", truth.turns(k));
    let text = table(&truth, "position", &turns);
    let said = asked("log.csv", &text, &["--counts-per-rev", "720"]);
    assert!(said.contains("--position position:rev"), "{said}");
    let flags = ["--counts-per-rev", "720", "--position", "position:rad"];
    let (_, said) = imported("log.csv", &text, &flags);
    assert!(
        said.contains("1/720 of a turn in rev") && said.contains("hint: --position position:rev"),
        "{said}"
    );
    // Plausible radians are not questioned, nor are round decimals.
    let rad = |k: usize| format!("{:.7}", truth.turns(k) * std::f64::consts::TAU);
    let (_, said) = imported("log.csv", &table(&truth, "position", &rad), &flags);
    assert!(!said.contains("hint: --position"), "{said}");
    let round = |k: usize| format!("{:.5}", (truth.turns(k) * 200.0).round() / 200.0);
    let said = asked("log.csv", &table(&truth, "position", &round), &[]);
    assert!(!said.contains("position:rev"), "{said}");
}

#[test]
fn rps_may_be_radians_or_revolutions() {
    let truth = Truth::steps(0.02, 300);
    let rad = |k: usize| {
        let counts = truth.counts[k] - truth.counts[k.saturating_sub(1)];
        format!(
            "{:.4}",
            counts as f64 / 720.0 * std::f64::consts::TAU / 0.02
        )
    };
    let text = table(&truth, "speed_rps", &rad);
    let said = asked("log.csv", &text, &[]);
    assert!(said.contains("radians or revolutions a second"), "{said}");
    assert_eq!(proposed(&said, &[])[1], "speed_rps:rad/s");
    // The steps are those of the stated counts for one of the two only.
    let (_, said) = imported("log.csv", &text, &["--counts-per-rev", "720"]);
    assert!(said.contains("in rad/s"), "{said}");
}

/// A motor that is braked by a command against its motion, and released before it reverses, has an encoder with a
/// sign.
#[test]
fn a_log_with_signs_is_not_taken_as_one_without() {
    let pwm = (0..400).map(|k| match k % 100 {
        0..60 => 200,
        60..64 => -200,
        _ => 0,
    });
    let truth = Truth::of(0.01, pwm);
    let steps = truth.counts.windows(2).map(|pair| pair[1] - pair[0]);
    assert!(steps.min() >= Some(0), "it never turns back");
    let turned = |k: usize| truth.counts[k].to_string();
    let flags = ["--counts-per-rev", "720"];
    let (file, said) = imported("log.csv", &table(&truth, "encoder", &turned), &flags);
    assert_eq!(counts(&file), truth.counts, "{said}");
    // With one channel it keeps turning, which is a question.
    let truth = Truth::steps(0.01, 300);
    let mut up = 0;
    let ups: Vec<i64> = (truth.rows())
        .map(|k| {
            up += (truth.counts[k] - truth.counts[k.saturating_sub(1)]).abs();
            up
        })
        .collect();
    let text = table(&truth, "encoder", &|k| ups[k].to_string());
    let said = asked("log.csv", &text, &flags);
    assert!(said.contains("--unsigned"), "{said}");
}

/// An efficiency, a charge or a load in percent is no command.
#[test]
fn per_cent_alone_is_no_command() {
    let truth = Truth::steps(0.01, 300);
    let ms = |k: usize| truth.ms(k).to_string();
    let turned = |k: usize| truth.counts[k].to_string();
    let share = |k: usize| (truth.pwm[k].abs() / 3).to_string();
    let text = log(
        "time_ms,Motor Efficiency (%),encoder",
        truth.rows(),
        &[&ms, &share, &turned],
    );
    let said = asked("log.csv", &text, &["--counts-per-rev", "720"]);
    assert!(said.contains("no column is named as a command"), "{said}");
    for name in ["control [%]", "throttle (%)", "Stellgröße [%]"] {
        let text = log(
            &format!("time_ms,{name},encoder"),
            truth.rows(),
            &[&ms, &share, &turned],
        );
        let said = asked("log.csv", &text, &["--counts-per-rev", "720"]);
        assert!(
            said.contains(&format!("command   `{name}` in percent")),
            "{said}"
        );
    }
}

#[test]
fn a_position_without_a_unit_is_proposed_in_the_one_whose_turn_its_steps_divide() {
    let truth = Truth::steps(0.01, 400);
    let turned = |k: usize| format!("{:.8}", (truth.turns(k) * 2048.0).floor() / 2048.0);
    let said = asked("log.csv", &table(&truth, "position", &turned), &[]);
    assert!(said.contains("--position position:rev"), "{said}");
    assert!(said.contains("steps of 1/2048 of a turn"), "{said}");
}

#[test]
fn the_voltage_of_a_sensor_is_neither_command_nor_position() {
    let truth = Truth::steps(0.01, 400);
    let light = |k: usize| {
        if truth.counts[k] / 30 % 2 == 0 {
            "4.8"
        } else {
            "0.2"
        }
        .to_owned()
    };
    let said = asked("log.csv", &table(&truth, "Photodiode (V)", &light), &[]);
    assert!(said.contains("command   `voltage` in V"), "{said}");
    assert!(said.contains("count its edges first"), "{said}");
    assert!(!said.contains("--speed Photodiode"), "{said}");
}

#[test]
fn units_of_other_languages_and_of_an_odrive_are_known() {
    let truth = Truth::steps(0.01, 400);
    let rpm = |k: usize| truth.rpm(k);
    for name in ["n [min^-1]", "n (1/min)", "vitesse (tr/min)", "giri/min"] {
        let (_, said) = imported(
            "log.csv",
            &table(&truth, name, &rpm),
            &["--counts-per-rev", "720"],
        );
        assert!(said.contains("in rpm"), "{name}: {said}");
    }
    let turned = |k: usize| format!("{:.6}", truth.turns(k) + 0.1234567 * truth.t_s(k));
    let said = asked(
        "log.csv",
        &table(&truth, "axis0.pos_estimate", &turned),
        &[],
    );
    assert!(said.contains("--position axis0.pos_estimate:rev"), "{said}");
    let said = asked("log.csv", &table(&truth, "speed km/h", &turned), &[]);
    assert!(said.contains("--m-per-rev METRES"), "{said}");
}
