//! Gaps and documents with made-up figures for unit tests.

use std::collections::BTreeMap;

use crate::diagnose::report::{
    Diagnosis, Fitted, FloorParts, Gap, NominalSource, Place, Regime, Region, SHAPE, Verdict,
};
use crate::motor::{CommandKind, Motor};

/// Rungs above a floor of rounding.
pub(crate) fn gap([before, after_parameters, after_effect]: [f64; 3], floor: f64) -> Gap {
    Gap {
        metric: "",
        horizon_s: 1.0,
        floor,
        floor_parts: FloorParts {
            rounding: floor,
            repeats: None,
            good_enough: None,
        },
        wander: 0.77,
        travel: 500.0,
        before,
        after_parameters,
        after_effect,
        closed: 0.9899,
        closed_lo95: 0.9,
        closed_hi95: 1.0,
        fitted: Fitted {
            before,
            after_parameters,
            after_effect,
        },
        held_out: String::new(),
        rungs95: [(0.0, 0.0); 3],
    }
}

/// A document of a verdict, 93 % sure.
pub(crate) fn diagnosis(verdict: Verdict, effects: Option<&&[&'static str]>) -> Diagnosis {
    let region = Region {
        run: "1".to_owned(),
        from_s: 0.0,
        to_s: 1.0,
        regime: Regime::Reversal,
        share: 0.6,
    };
    Diagnosis {
        shape: SHAPE,
        verdict,
        sentence: String::new(),
        parts: Default::default(),
        probability: 0.93,
        effects: effects.map_or_else(Vec::new, |set| set.to_vec()),
        causes: Vec::new(),
        place: Place {
            stage: None,
            stage_probabilities: BTreeMap::new(),
            regions: vec![region],
        },
        gap: gap([12.3, 4.5, 0.44], 0.31),
        sets: Vec::new(),
        base: BTreeMap::new(),
        note: String::new(),
        data: Vec::new(),
        next_experiment: None,
        steps: Vec::new(),
        elapsed_s: 0.0,
        simulated_samples: 0,
        reference: None,
        fitted_nominal: None,
        nominal_source: NominalSource::Given,
        predicted: Vec::new(),
        command_kind: CommandKind::Voltage,
        nominal: Motor::default(),
        model: Motor::default(),
        refitted: Motor::default(),
    }
}
