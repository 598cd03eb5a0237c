//! docs/reference/effects.md is the catalogue, written out. `UPDATE_DOCS=1 cargo test --test effects_table` writes it anew.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use motorlab::effects::{experiment, twin};
use motorlab::motor::catalogue::{Prior, Scale, Stage, catalogue, find};

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

fn table() -> String {
    let mut out = String::from(
        "# The catalogue of effects\n\n\
         Written from the registry in `motor-chain/src/catalogue.rs`; `UPDATE_DOCS=1 cargo test --test effects_table` writes it anew.\n\n\
         In a motor file an effect is a table `[effects.<id>]` with the parameters below; one that is left out takes the\n\
         middle of its plausible range. On the virtual board it is `virtual:?effect=<id>&<key>=<value>`. Any set of effects\n\
         can be combined. `motorlab effects ID` says the same in figures, for your motor too. Plausible ranges are priors, in multiples
\
         of the motor's own numbers: Tf, b, J, R and supply are the motor file's, TS is the sample time. w0 is the supply over Kb, stall is
\
         the supply over R, stall torque is Kt times that, tau is J / (b + Kt Kb / R). A motor of 600 rad/s or 24 V has ranges of its own size.

\
         What repeats with the angle may be in a motor twice, with other orders: `[effects.\"cogging#2\"]` beside `[effects.cogging]`, and
\
         `[effects.\"torque_ripple#2\"]`. How the equations combine and are solved: [simulation.md](../method/simulation.md).

\
         The last column is an experiment, at a sample time of 3 ms: in it the default strength shows on the handout's motor. No motor
\
         without the effect makes the same run, whatever its gain, time constant and friction: they differ by D of at least 3
\
         (`tests/effects_shown.rs`). Of the effects marked with an asterisk no run of counts tells that much; why is below.
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
                "| `{}`: {} | {} | {} | {} | {} | `{}`, {} s{} |",
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
                if twin(kind).is_some() { " *" } else { "" },
            );
        }
    }
    out.push_str("\n## What has a twin\n\nVoltage in and counts out do not tell these from other numbers of the motor file. Tolerances do, where they are narrow.\n\n");
    for kind in catalogue() {
        if let Some(why) = twin(kind) {
            let _ = writeln!(out, "- `{}`: {why}.", kind.id);
        }
    }
    out.push_str("\n## Sources\n\n");
    for kind in catalogue() {
        let _ = writeln!(out, "- `{}`: {}.", kind.id, kind.source);
    }
    out
}

#[test]
fn the_documented_table_is_the_registry() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/reference/effects.md");
    let table = table();
    if std::env::var_os("UPDATE_DOCS").is_some() {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, &table).unwrap();
    }
    let there = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        there == table,
        "docs/reference/effects.md is not the registry's: UPDATE_DOCS=1 cargo test --test effects_table"
    );
}

#[test]
fn the_catalogue_is_the_contract() {
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
