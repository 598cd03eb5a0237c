//! docs/reference/effects.md is the catalogue as text, with a figure of each effect's trace. `UPDATE_DOCS=1 cargo
//! test --test effects table::` regenerates both.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use motorlab::board::Profile;
use motorlab::effects::{experiment, not_identifiable};
use motorlab::motor::catalogue::{EffectKind, Prior, Scale, Stage, catalogue, find};
use motorlab::motor::{
    ActiveEffect, CommandKind, Drive, Motor, Parameters, SimulationOptions, simulate,
};
use motorlab::report::{Figure, Panel, Series, Size, Stroke, svg};
use motorlab::units::rpm_from_rad_s;

/// Samples between the points of a figure: at 3 ms the lab's slow sample time, 30 ms.
const EVERY: usize = 10;
/// For a page of text, and a phone.
const PICTURE: Size = Size {
    width: 640,
    height: 340,
};

/// A file of the reference.
fn reference(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("docs/reference")
        .join(name)
}

/// Encoder reading of the handout's motor, with the effect at its default strength and without it.
fn trace(kind: &EffectKind) -> String {
    let plan = experiment(kind);
    let samples = (plan.duration_s / plan.sample_time_s).round() as usize;
    let t_s: Vec<f64> = (0..samples)
        .map(|k| k as f64 * plan.sample_time_s)
        .collect();
    let supply_v = Parameters::default().supply_v;
    let profile = Profile::named(plan.profile, supply_v, plan.duration_s).expect("a profile");
    let drive = Drive {
        t_s: &t_s,
        command: &profile.commands(plan.sample_time_s, samples),
        kind: CommandKind::Voltage,
    };
    let turns = |motor: &Motor, per_rev: f64| -> Vec<f64> {
        let run = simulate(motor, &drive, &SimulationOptions::default()).expect("a motion");
        if kind.random {
            run.counts.iter().map(|n| *n as f64 / per_rev).collect()
        } else {
            run.measured_angle_rad.iter().map(|a| a / TAU).collect()
        }
    };
    let mut motor = Motor::default();
    let per_rev = motor.parameters.counts_per_rev;
    let without = turns(&motor, per_rev);
    let effect = ActiveEffect::from_keys(kind.id, [], &Parameters::default()).expect("its id");
    motor.effects.set(effect);
    let with = turns(&motor, per_rev);
    let apart_s = EVERY as f64 * plan.sample_time_s;
    let speed = |turns: &[f64]| -> Vec<(f64, f64)> {
        let points = (EVERY..samples).step_by(EVERY);
        points
            .map(|k| {
                let speed = rpm_from_rad_s(TAU * (turns[k] - turns[k - EVERY]) / apart_s);
                (t_s[k], speed)
            })
            .collect()
    };
    let gap = (0..samples)
        .step_by(EVERY)
        .map(|k| (t_s[k], per_rev * (with[k] - without[k])))
        .collect();
    let series = |name: &str, stroke, colour, points| Series {
        name: name.to_owned(),
        stroke,
        colour,
        points,
    };
    let figure = Figure {
        title: format!("{}: {}", kind.id, kind.summary),
        x_label: "time (s)".to_owned(),
        panels: vec![
            Panel::new(
                "speed (RPM)",
                vec![
                    series("without the effect", Stroke::Broad, 1, speed(&without)),
                    series("with the effect", Stroke::Line, 0, speed(&with)),
                ],
            )
            .weighing(1.6),
            Panel::new(
                "error (counts)",
                vec![series("with less without", Stroke::Line, 3, gap)],
            ),
        ],
    };
    svg::document(&figure, PICTURE)
}

fn scale(scale: Scale) -> &'static str {
    match scale {
        Scale::Absolute => "",
        Scale::SampleTime => " TS",
        Scale::Count => " counts",
        Scale::StallCurrent => " stall",
        Scale::Resistance => " R",
        Scale::NoLoadSpeed => " w0",
        Scale::StallTorque => " stall torque",
        Scale::TimeConstant => " tau",
        Scale::TimeConstantAsFrequency => " / (2 pi tau)",
        Scale::ResistanceTimesTimeConstant => " R tau",
        Scale::PerStallPower => " / stall power",
        Scale::CoulombTorque => " Tf",
        Scale::ViscousCoefficient => " b",
        Scale::Inertia => " J",
        Scale::TopRate => " top edge rate",
        Scale::Supply => " supply",
        Scale::DragAtTopSpeed => " b / top speed",
    }
}

/// Path of its figure from the page.
fn picture(kind: &EffectKind) -> String {
    format!("effects/{}.svg", kind.id)
}

fn table() -> String {
    let mut out = String::from(
        "# The catalogue of effects\n\n\
         Written from the registry in `motor-chain/src/catalogue.rs`; `UPDATE_DOCS=1 cargo test --test effects table::` writes it anew.\n\n\
         In a motor file an effect is a table `[effects.<id>]` with the parameters below. One that is left out takes the\n\
         middle of its plausible range. On the virtual board it is `virtual:?effect=<id>&<key>=<value>`. Any set of effects\n\
         can be combined. Each has a page; `motorlab explain ID` prints it, `motorlab effects ID` has the values for your motor. Plausible ranges are priors, in multiples
\
         of the motor's parameters. Tf, b, J, R and supply are the motor file's, TS is the sample time. w0 is the supply over Kb, stall is
\
         the supply over R, stall torque is Kt times that. tau is J / (b + Kt Kb / R). A motor of 600 rad/s or 24 V has ranges of its own size.

\
         An effect that repeats with the angle can be used twice, with different orders: `[effects.\"cogging#2\"]` beside `[effects.cogging]`, and
\
         `[effects.\"torque_ripple#2\"]`. How the equations combine and are solved: [simulation.md](../method/simulation.md).

\
         The last column is an experiment, at a sample time of 3 ms: in it the default strength shows on the handout's motor. No motor
\
         without the effect makes the same run, whatever its gain, time constant and friction: they differ by D of at least 3
\
         (`tests/effects/shown.rs`). Effects marked with an asterisk are not identifiable from counts alone; the reasons are below.
",
    );
    for stage in Stage::ALL {
        let _ = writeln!(out, "\n## {stage}\n");
        out.push_str("| effect | equation | parameters: plausible range | shows in | easily confused with | experiment |\n| --- | --- | --- | --- | --- | --- |\n");
        for kind in catalogue().iter().filter(|kind| kind.stage == stage) {
            let shown = experiment(kind);
            let mut parameters = Vec::new();
            for p in kind.parameters {
                let range = match p.prior {
                    Prior::Phase => "0 .. 2 pi".to_owned(),
                    Prior::OneOf(values) if values.len() < 3 => values
                        .iter()
                        .map(f64::to_string)
                        .collect::<Vec<_>>()
                        .join(" or "),
                    Prior::OneOf(_) => "common resolutions".to_owned(),
                    Prior::Uniform | Prior::LogUniform => {
                        let mut range = format!("{:.3} .. {:.3}{}", p.lo, p.hi, scale(p.scale));
                        if let Some((multiple, other)) = p.or_up_to {
                            let _ =
                                write!(range, " or {multiple:.3}{}, what is more", scale(other));
                        }
                        if p.at_most < f64::MAX {
                            let _ = write!(range, ", at most {:.3}", p.at_most);
                        }
                        range
                    }
                };
                let unit = if p.unit.is_empty() {
                    String::new()
                } else {
                    format!(" ({})", p.unit)
                };
                parameters.push(format!("`{}`{unit}: {range}", p.key));
            }
            let _ = writeln!(
                out,
                "| [`{}`](effects/{}.md): {} | {} | {} | {} | {} | `{}`, {} s{} |",
                kind.id,
                kind.id,
                kind.summary,
                kind.equation.replace('|', "\\|"),
                if parameters.is_empty() {
                    "none".to_owned()
                } else {
                    parameters.join("; ")
                },
                kind.excited_by,
                kind.confounded_with.join(", "),
                shown.profile,
                shown.duration_s,
                if not_identifiable(kind).is_some() {
                    " *"
                } else {
                    ""
                },
            );
        }
    }
    out.push_str("\n## Not identifiable from voltage and counts\n\nVoltage and counts do not separate these from parameters of the motor file. Narrow tolerances do.\n\n");
    for kind in catalogue() {
        if let Some(why) = not_identifiable(kind) {
            let _ = writeln!(out, "- `{}`: {why}.", kind.id);
        }
    }
    out
}

#[test]
fn the_documented_table_is_the_registry() {
    let path = reference("effects.md");
    let table = table();
    if std::env::var_os("UPDATE_DOCS").is_some() {
        fs::create_dir_all(reference("effects")).unwrap();
        fs::write(&path, &table).unwrap();
    }
    let there = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        there == table,
        "docs/reference/effects.md is not the registry's: UPDATE_DOCS=1 cargo test --test effects table::"
    );
}

#[test]
fn each_effect_has_a_picture_that_shows_its_gap() {
    for kind in catalogue() {
        let path = reference(&picture(kind));
        if std::env::var_os("UPDATE_DOCS").is_some() {
            fs::create_dir_all(reference("effects")).expect("a folder");
            fs::write(&path, trace(kind)).expect("a file");
        }
        let drawn = fs::read_to_string(&path).unwrap_or_default();
        let named = drawn.contains(&format!(">{}: ", kind.id));
        assert!(
            named,
            "{path:?}: UPDATE_DOCS=1 cargo test --test effects table::"
        );
        // The last curve is the gap: it uses the height of its panel, and is not quantization noise.
        let gap = drawn
            .rsplit("<path class=\"curve\" d=\"")
            .next()
            .expect("a curve");
        let path = gap.split('"').next().expect("a path");
        let heights: Vec<f64> = (path.split(['M', 'L']).skip(1))
            .filter_map(|point| point.split_once(' '))
            .filter_map(|(_, y)| y.parse().ok())
            .collect();
        let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let highest = heights.iter().copied().fold(0.0, f64::max);
        assert!(
            heights.len() > 100 && highest - lowest > 20.0,
            "{}",
            kind.id
        );
    }
}

#[test]
fn the_catalogue_has_the_documented_names() {
    let stages = [
        (
            "command",
            &[
                "transport_delay",
                "command_offset",
                "dead_zone",
                "asymmetric_dead_zone",
            ][..],
        ),
        (
            "driver",
            &[
                "voltage_drop",
                "asymmetric_voltage_drop",
                "supply_sag",
                "supply_error",
                "asymmetric_gain",
                "current_limit",
                "coast_at_zero",
                "pwm_freewheel",
            ],
        ),
        (
            "electrical",
            &[
                "inductance",
                "winding_heating",
                "magnet_weakening",
                "torque_ripple",
            ],
        ),
        (
            "mechanical",
            &[
                "coulomb_friction",
                "viscous_friction",
                "asymmetric_viscous",
                "inertia",
                "stribeck",
                "asymmetric_friction",
                "static_friction",
                "presliding",
                "load_friction",
                "quadratic_drag",
                "gravity_load",
                "constant_load",
                "cogging",
            ],
        ),
        (
            "transmission",
            &["backlash", "compliance", "slipping_clutch"],
        ),
        (
            "sensor",
            &[
                "resolution_error",
                "missed_counts",
                "edge_rate_loss",
                "encoder_eccentricity",
                "speed_filter",
            ],
        ),
        ("timing", &["sample_jitter", "clock_error"]),
    ];
    let listed: Vec<_> = catalogue()
        .iter()
        .map(|kind| (kind.stage.id(), kind.id))
        .collect();
    let agreed: Vec<_> = stages
        .iter()
        .flat_map(|(stage, ids)| ids.iter().map(move |id| (*stage, *id)))
        .collect();
    assert_eq!(listed, agreed);
    let parameters = motorlab::motor::Parameters::default();
    for kind in catalogue() {
        for p in kind.parameters {
            let (lo, hi) = p.range(&parameters, 0.003);
            let default = p.default(&parameters, 0.003);
            assert!(
                lo <= hi && (p.possible.0..=p.possible.1).contains(&default),
                "{} {}",
                kind.id,
                p.key
            );
            assert!(
                lo >= p.possible.0 && hi <= p.possible.1,
                "{} {}",
                kind.id,
                p.key
            );
        }
        for other in kind.confounded_with {
            let known = find(other).is_some()
                || parameters.get(other).is_some()
                || *other == "process noise";
            assert!(
                known,
                "{}: '{other}' is neither an effect nor a parameter",
                kind.id
            );
        }
    }
}
