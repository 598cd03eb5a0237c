//! Motors near the limits of simulation: a body that creeps to rest does not chatter, and a motor that only stops and
//! breaks away gives an error in a fit, not an endless fit.

use motorlab::motor::fit::{Simulator, Workspace};
use motorlab::motor::{
    ActiveEffect, Drive, Model, Motor, SimulationError, SimulationOptions, simulate,
};
use motorlab::recording::CommandKind;

const SAMPLE_TIME_S: f64 = 0.003;

fn motor(effects: &[(&str, &[f64])]) -> Motor {
    let mut motor = Motor::default();
    for (id, values) in effects {
        motor.effects.set(ActiveEffect::new(id, values).unwrap());
    }
    motor
}

fn times(command: &[f64]) -> Vec<f64> {
    (0..command.len())
        .map(|k| k as f64 * SAMPLE_TIME_S)
        .collect()
}

/// Each of these comes to rest exactly at a level, where rounding would alternate sticking and slipping for ever.
#[test]
fn a_body_that_approaches_its_equilibrium_stays_there() {
    // Spring (Hz, damping, share of the load, side), b, L, Tf, and the levels.
    let cases = [
        (
            [
                37.46133006044081,
                0.07285395177510126,
                0.8958732064838999,
                1.0,
            ],
            [
                0.0719558508337186,
                0.017213672497770224,
                0.053594497203340946,
            ],
            [
                -2.149867836106894,
                2.798973265379596,
                0.6228020837403188,
                3.0786458285275966,
                -3.582137247555484,
            ],
        ),
        (
            [
                33.50416442177293,
                2.423428368549966,
                0.7147429850616464,
                1.0,
            ],
            [
                0.004863320085094747,
                0.0009079512816960644,
                0.032024683673647567,
            ],
            [
                -0.756700259799739,
                2.446882794868963,
                0.35398905857340957,
                1.6791526863926025,
                1.3334951343991914,
            ],
        ),
        (
            [
                27.04115196481153,
                0.7825234387053717,
                0.7929435977958141,
                1.0,
            ],
            [
                0.029679450333806298,
                0.0005508825787913144,
                0.08231515918589909,
            ],
            [
                -0.2460171625229668,
                -3.0874308109891286,
                -3.2877709439801253,
                -3.7059538912632464,
                4.229115796532097,
            ],
        ),
        (
            [
                42.699171417144385,
                1.3040580784900357,
                0.5325936262652605,
                0.0,
            ],
            [
                0.0006830633071653119,
                0.02351194765852413,
                0.08852999650581418,
            ],
            [
                -1.2074740780370776,
                -1.0420510772375096,
                1.0775152151008784,
                -2.6621200582228077,
                -0.2482701246123824,
            ],
        ),
    ];
    for (spring, [b, l, tf], levels) in cases {
        let mut motor = motor(&[("compliance", &spring)]);
        motor.parameters.viscous_friction_nm_s_per_rad = b;
        motor.parameters.inductance_h = l;
        motor.parameters.coulomb_friction_nm = tf;
        let command: Vec<f64> = levels
            .iter()
            .flat_map(|&u| [vec![u; 150], vec![0.0; 300], vec![0.1 * u; 300]].concat())
            .collect();
        let t_s = times(&command);
        let drive = Drive {
            t_s: &t_s,
            command: &command,
            kind: CommandKind::Voltage,
        };
        let mut angles = vec![0.0; command.len()];
        // The simulator for fits stops at 100 steps a sample: chatter is two thousand.
        Simulator::new(&drive, Model::SecondOrder)
            .unwrap()
            .angles(&motor, &mut Workspace::default(), &mut angles)
            .unwrap();
    }
}

#[test]
fn a_motor_with_endless_events_is_an_error() {
    // Detents of 10 kN m, a thousand per revolution: the shaft oscillates in one at sqrt(A N / J) = 71 krad/s and
    // stops twice per period.
    let motor = motor(&[("cogging", &[1e4, 1e3, 0.5])]);
    let command = vec![4.5; 200];
    let t_s = times(&command);
    let drive = Drive {
        t_s: &t_s,
        command: &command,
        kind: CommandKind::Voltage,
    };
    let mut angles = vec![0.0; command.len()];
    let error = Simulator::new(&drive, Model::SecondOrder)
        .unwrap()
        .angles(&motor, &mut Workspace::default(), &mut angles)
        .unwrap_err();
    // 100 steps for each of 200 longest ones.
    assert!(matches!(error, SimulationError::TooStiff { steps, .. } if steps > 20_000));
    assert!(error.to_string().contains("too stiff to simulate"));
    // A single simulation may take longer: steps are at least a tick long, so that it ends.
    let run = simulate(&motor, &drive, &SimulationOptions::default()).unwrap();
    assert!(run.angle_rad.iter().all(|x| x.abs() < 0.01));
}
