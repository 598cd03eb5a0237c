//! Constants of an exported actuator: named, with units, at the top of each file.

use crate::motor::catalogue::ids;
use std::f64::consts::TAU;

use crate::export::PARAMETERS;
use crate::motor::{Motor, Parameters};

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Constant {
    pub name: String,
    pub value: f64,
    pub unit: &'static str,
    pub meaning: String,
}

/// Longest inner step in s: at 0.25 ms the handout's motor differs by less than 0.001 counts from the simulator.
const LONGEST_S: f64 = 2.5e-4;
/// Inner steps per shortest time constant: fourth order leaves an error of some 1e-4.
const PER_ELECTRICAL: f64 = 2.0;
/// The same where the equations have a kink within a mode or the current is held at 0.
const PER_ELECTRICAL_KINKED: f64 = 5.0;
const PER_MECHANICAL: f64 = 10.0;
const PER_PERIOD: f64 = 40.0;
/// Shortest inner step in s. A winding with L/R below it has no current state: an error below 0.001 counts at one
/// turn a second.
const SHORTEST_S: f64 = 2e-6;

/// Parameters after folding in the effects that replace one of them.
pub(super) fn folded(motor: &Motor) -> Parameters {
    let mut p = motor.parameters;
    for effect in motor.effects.iter() {
        let value = effect.values[0];
        match effect.kind().id {
            ids::COULOMB_FRICTION => p.coulomb_friction_nm = value,
            ids::VISCOUS_FRICTION => p.viscous_friction_nm_s_per_rad = value,
            ids::INERTIA => p.inertia_kg_m2 = value,
            ids::INDUCTANCE => p.inductance_h = value,
            _ => {}
        }
    }
    if p.inductance_h < SHORTEST_S * p.resistance_ohm {
        p.inductance_h = 0.0;
    }
    p
}

/// Values of an effect that is part of the model.
pub(super) fn of(motor: &Motor, id: &str) -> Option<[f64; 5]> {
    motor.effects.get(id).map(|effect| effect.values)
}

/// The transmission: values of its effect with precedence, as in the simulator.
pub(super) struct Division {
    pub load_share: f64,
    pub load_friction_share: f64,
    pub encoder_on_load: bool,
}

impl Division {
    pub(super) fn of(motor: &Motor) -> Option<Self> {
        let (f, on_load, weight) = match (of(motor, ids::BACKLASH), of(motor, ids::COMPLIANCE)) {
            (_, Some(v)) => (v[2], v[3] >= 0.5, v[4]),
            (Some(v), None) => (v[1], v[2] >= 0.5, v[3]),
            (None, None) => (of(motor, ids::SLIPPING_CLUTCH)?[1], false, 1.0),
        };
        Some(Self {
            load_share: f,
            load_friction_share: weight * f / (1.0 - f + weight * f),
            encoder_on_load: on_load,
        })
    }
}

/// Every constant that the equations can name; a file has those that its equations use.
pub(super) fn constants(motor: &Motor) -> Vec<Constant> {
    let p = folded(motor);
    let mut all: Vec<Constant> = Vec::new();
    let mut add = |name: &str, value: f64, unit: &'static str, meaning: &str| {
        all.push(Constant {
            name: name.to_owned(),
            value,
            unit,
            meaning: meaning.to_owned(),
        });
    };
    for named in PARAMETERS {
        let name = named.key.to_uppercase();
        add(&name, named.value(&p), named.unit, named.meaning);
    }
    for effect in motor.effects.iter() {
        let kind = effect.kind();
        for (parameter, value) in effect.parameters() {
            let name = format!("{}_{}", kind.id.replace('#', "_"), parameter.key).to_uppercase();
            add(&name, value, parameter.unit, kind.summary);
        }
    }
    let drops = |k: usize| {
        let one = of(motor, ids::VOLTAGE_DROP).map_or(0.0, |v| v[0]);
        one + of(motor, ids::ASYMMETRIC_VOLTAGE_DROP).map_or(0.0, |v| v[k])
    };
    add(
        "DROP_FORWARD_V",
        drops(0),
        "V",
        "lost against a positive current",
    );
    add(
        "DROP_BACK_V",
        drops(1),
        "V",
        "lost against a negative current",
    );
    let heats = of(motor, ids::WINDING_HEATING).map(|v| v[1]);
    let weakens = of(motor, ids::MAGNET_WEAKENING);
    if let Some(s) = heats.or(weakens.map(|v| v[1])) {
        add(
            "HEATING_TIME_CONSTANT_S",
            s,
            "s",
            "time constant of the filtered copper loss",
        );
    }
    if let Some(v) = weakens {
        let per_w = v[0] * p.resistance_ohm / (p.supply_v * p.supply_v);
        add(
            "WEAKENING_PER_W",
            per_w,
            "1/W",
            "share of Kt and Kb lost per watt of copper loss",
        );
    }
    if let Some(division) = Division::of(motor) {
        let (j, f, q) = (
            p.inertia_kg_m2,
            division.load_share,
            division.load_friction_share,
        );
        add(
            "MOTOR_INERTIA_KG_M2",
            (1.0 - f) * j,
            "kg m^2",
            "inertia of the motor side",
        );
        add(
            "LOAD_INERTIA_KG_M2",
            f * j,
            "kg m^2",
            "inertia of the load side",
        );
        add(
            "MOTOR_FRICTION_SHARE",
            1.0 - q,
            "",
            "share of the friction on the motor side",
        );
        add(
            "LOAD_FRICTION_SHARE",
            q,
            "",
            "share of the friction on the load side",
        );
        if let Some(v) = of(motor, ids::COMPLIANCE) {
            let (rate, reduced) = (v[0] * TAU, (1.0 - f) * f * j);
            add(
                "SPRING_NM_PER_RAD",
                rate * rate * reduced,
                "N m/rad",
                "stiffness of the transmission",
            );
            add(
                "DAMPER_NM_S_PER_RAD",
                2.0 * v[1] * rate * reduced,
                "N m s/rad",
                "damping of the transmission",
            );
        }
    }
    add("INNER_S", inner_s(motor, &p), "s", "longest inner step");
    all
}

/// Inertia of the output shaft in kg m^2: the load side of a transmission, or the whole motor.
pub fn output_inertia(motor: &Motor) -> f64 {
    let share = Division::of(motor).map_or(1.0, |division| division.load_share);
    share * folded(motor).inertia_kg_m2
}

/// Inner step for the shortest time constant of the motor.
fn inner_s(motor: &Motor, p: &Parameters) -> f64 {
    let mut shortest = LONGEST_S;
    let mut within = |time_s: f64, steps: f64| {
        if time_s > 0.0 {
            shortest = shortest.min(time_s / steps);
        }
    };
    let kinked = [
        ids::VOLTAGE_DROP,
        ids::ASYMMETRIC_VOLTAGE_DROP,
        ids::CURRENT_LIMIT,
        ids::LOAD_FRICTION,
    ];
    let per_electrical = match kinked.iter().any(|id| of(motor, id).is_some()) {
        true => PER_ELECTRICAL_KINKED,
        false => PER_ELECTRICAL,
    };
    within(p.inductance_h / p.resistance_ohm, per_electrical);
    let back_emf = p.torque_constant_nm_per_a * p.back_emf_v_s_per_rad / p.resistance_ohm;
    let lightest = Division::of(motor).map_or(1.0, |d| d.load_share.min(1.0 - d.load_share));
    let rate = (p.viscous_friction_nm_s_per_rad + back_emf) / p.inertia_kg_m2;
    within(lightest / rate, PER_MECHANICAL);
    if let Some(v) = of(motor, ids::COMPLIANCE) {
        within(1.0 / v[0], PER_PERIOD);
    }
    let top_speed = p.supply_v / p.back_emf_v_s_per_rad;
    for id in [
        ids::COGGING,
        "cogging#2",
        ids::TORQUE_RIPPLE,
        "torque_ripple#2",
    ] {
        if let Some(v) = of(motor, id) {
            within(TAU / (v[1] * top_speed), PER_PERIOD);
        }
    }
    if let Some(v) = of(motor, ids::STRIBECK) {
        // The time in which stall torque accelerates the motor through the Stribeck speed.
        let stall_nm = p.torque_constant_nm_per_a * p.supply_v / p.resistance_ohm;
        within(v[1] * p.inertia_kg_m2 / stall_nm, PER_MECHANICAL);
    }
    shortest.max(SHORTEST_S)
}
