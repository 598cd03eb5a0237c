//! What is said of a recording in which something fatal was found, where somebody asks for a diagnosis all the same.

use super::sentence::sentence;
use super::verdict::Diagnosis;

/// The most that is said then: what is wrong with the recording may be all that there is (convention).
const AT_MOST: f64 = 0.9;

/// The diagnosis with no probability above 90 %, in its numbers and in its sentence alike. What is taken from the likeliest goes to
/// something unknown; where that is the likeliest itself, to none.
pub fn despite_findings(mut diagnosis: Diagnosis) -> Diagnosis {
    let causes = &diagnosis.causes;
    let sets = &diagnosis.sets;
    let largest = (causes.iter().map(|cause| cause.probability))
        .chain(sets.iter().map(|set| set.probability))
        .fold(diagnosis.probability, f64::max);
    if largest > AT_MOST {
        let share = AT_MOST / largest;
        let likeliest = causes.first().map_or("", |cause| cause.effect);
        let heir = if likeliest == "unknown" {
            "none"
        } else {
            "unknown"
        };
        for cause in &mut diagnosis.causes {
            cause.probability *= share;
            if cause.effect == heir {
                cause.probability += 1.0 - share;
            }
        }
        for set in &mut diagnosis.sets {
            set.probability *= share;
        }
        diagnosis.probability *= share;
    }
    for cause in &mut diagnosis.causes {
        cause.inclusion = cause.inclusion.min(AT_MOST);
    }
    (diagnosis.causes).sort_by(|a, b| b.probability.total_cmp(&a.probability));
    diagnosis.sentence = sentence(&diagnosis);
    diagnosis
}
