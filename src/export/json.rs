//! JSON (`motorlab-motor/1`): every parameter and effect with its unit and equation.

use serde_json::{Map, Value, json};

use super::{EQUATIONS, PARAMETERS};
use crate::motor::Motor;

/// The motor as one JSON document.
pub fn document(motor: &Motor) -> Value {
    let parameters: Map<String, Value> = PARAMETERS
        .iter()
        .map(|named| {
            let entry = json!({
                "value": named.value(&motor.parameters),
                "unit": named.unit,
                "symbol": named.symbol,
                "meaning": named.meaning,
                "tolerance": motor.tolerance.get(named.key),
            });
            (named.key.to_owned(), entry)
        })
        .collect();
    let effects: Map<String, Value> = motor
        .effects
        .iter()
        .map(|effect| {
            let values: Map<String, Value> = effect
                .parameters()
                .map(|(parameter, value)| {
                    let entry = json!({ "value": value, "unit": parameter.unit });
                    (parameter.key.to_owned(), entry)
                })
                .collect();
            let kind = effect.kind();
            let entry = json!({
                "stage": kind.stage,
                "summary": kind.summary,
                "equation": kind.equation,
                "parameters": values,
            });
            (kind.id.to_owned(), entry)
        })
        .collect();
    let mut document = json!({
        "shape": "motorlab-motor/1",
        "equations": EQUATIONS,
        "parameters": parameters,
        "effects": effects,
    });
    if motor.resistance_assumed {
        document["assumed"] = motor.assumptions().into();
    }
    document
}
