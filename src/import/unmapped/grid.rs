//! Numbers on a grid: the step of a speed is one count in a sample time, that of an angle one count.
//!
//! The step is the largest one of which all numbers are multiples, within the rounding of their digits. It is
//! accepted if that is improbable at random: uniformly distributed numbers are within `tolerance` of a multiple of
//! `step` with the probability `2 tolerance / step` each.

/// Largest probability of a grid at random.
const AT_RANDOM: f64 = 1e-6;
/// Largest share of numbers off the grid: one disturbed sample in a thousand.
const OFF: f64 = 1e-3;
/// Smallest distances between neighbours that are tried as steps.
const DISTANCES: usize = 6;
/// Levels that differ by the last digit are merged, so that any numbers have steps of two digits (4 roundings); a
/// step above this is significant.
const SIGNIFICANT: f64 = 4.5;
/// Largest multiple of the step that the smallest distance may be.
const MULTIPLES: u32 = 4;

/// The step of these numbers, if they have one. `rounding` is half the last printed digit.
pub(super) fn step_of(numbers: &[f64], rounding: f64) -> Option<f64> {
    let mut levels: Vec<f64> = (numbers.iter().filter(|x| x.is_finite()))
        .map(|x| x.abs())
        .collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup_by(|a, b| (*a - *b).abs() <= 2.0 * rounding + tolerance(*b, 0.0));
    if levels.len() < 3 {
        return None;
    }
    let mut distances: Vec<f64> = levels
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .chain(levels.first().copied().filter(|first| *first > 0.0))
        .filter(|distance| *distance > 3.0 * rounding)
        .collect();
    distances.sort_by(f64::total_cmp);
    distances.dedup_by(|a, b| (*a - *b).abs() <= 4.0 * rounding);
    distances.truncate(DISTANCES);
    let candidates = distances
        .into_iter()
        .flat_map(|distance| (1..=MULTIPLES).map(move |parts| distance / f64::from(parts)));
    let is_significant = |step: &f64| *step > SIGNIFICANT * rounding || all_on(numbers, *step);
    candidates
        .filter_map(|step| on_grid(&levels, step, rounding))
        .filter(is_significant)
        .max_by(f64::total_cmp)
}

fn all_on(numbers: &[f64], step: f64) -> bool {
    let is_on = |x: &f64| (x - (x / step).round() * step).abs() <= tolerance(*x, 0.0);
    numbers.iter().filter(|x| x.is_finite()).all(is_on)
}

/// The step refined over all levels, if they are its multiples.
fn on_grid(levels: &[f64], step: f64, rounding: f64) -> Option<f64> {
    let (mut step, mut products, mut squares, mut off) = (step, 0.0, 0.0, 0);
    // Ascending: each level refines the step enough for the next.
    for &level in levels {
        let multiple = (level / step).round();
        if (level - multiple * step).abs() > 0.25 * step {
            off += 1;
            continue;
        }
        products += level * multiple;
        squares += multiple * multiple;
        if squares > 0.0 {
            step = products / squares;
        }
    }
    // Error of the step due to the rounding of the levels that determined it.
    let step_off = 2.0 * rounding / squares.sqrt().max(1.0);
    let within = |level: f64| {
        let multiple = (level / step).round();
        let most = tolerance(level, rounding) + multiple * step_off;
        (level - multiple * step).abs() <= most
    };
    let strays = levels.iter().filter(|level| !within(**level)).count();
    if off.max(strays) as f64 > OFF * levels.len() as f64 {
        return None;
    }
    let chance: f64 = levels
        .iter()
        .map(|level| (2.0 * tolerance(*level, rounding) / step).min(1.0).ln())
        .sum();
    (chance < AT_RANDOM.ln()).then_some(step)
}

/// Half the last digit plus the rounding of a 32-bit float, which sketches use.
fn tolerance(level: f64, rounding: f64) -> f64 {
    1.02 * rounding + 2.0 * f64::from(f32::EPSILON) * level.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn printed(multiples: impl Iterator<Item = i32>, step: f64, digits: usize) -> Vec<f64> {
        multiples
            .map(|m| {
                format!("{:.digits$}", f64::from(m) * step)
                    .parse()
                    .expect("a number")
            })
            .collect()
    }

    #[test]
    fn the_step_of_a_speed_is_found_from_its_digits() {
        for (step, digits) in [
            (0.1875, 3),
            (5.0 / 3.0, 2),
            (3.125, 1),
            (60.0 / 7.2, 2),
            (5.0, 0),
        ] {
            let numbers = printed((-40..120).map(|k| k * k % 97), step, digits);
            let found = step_of(&numbers, 0.5 * 0.1_f64.powi(digits as i32)).expect("steps");
            assert!((found / step - 1.0).abs() < 1e-3, "{step}: {found}");
        }
    }

    #[test]
    fn continuous_values_have_no_step() {
        let filtered: Vec<f64> = (0..400)
            .map(|k| 300.0 * (1.0 - (-0.01 * f64::from(k)).exp()))
            .collect();
        assert_eq!(step_of(&filtered, 0.005), None);
        // Rounded to integers, steps of 5/3 are not distinguishable from the rounding.
        let rounded: Vec<f64> = (0..100)
            .map(|k| (f64::from(k) * 5.0 / 3.0).round())
            .collect();
        assert_eq!(step_of(&rounded, 0.5), None);
        assert_eq!(step_of(&[0.0, 5.0], 0.5), None);
        let whole: Vec<f64> = (0..100).map(f64::from).collect();
        assert_eq!(step_of(&whole, 0.5), None);
        let even: Vec<f64> = (0..100).map(|k| 2.0 * f64::from(k)).collect();
        assert_eq!(step_of(&even, 0.5), Some(2.0));
    }
}
