//! Classification of a column's values as readings of a clock.

/// Share of rows that may repeat a reading by accident; above it several rows share one.
const REPEATS: f64 = 0.02;
/// Largest ratio of decreases to increases of a clock: restarts and blocks.
const FALLS: f64 = 0.25;
/// A time since the previous row is within this factor of its median...
const SPREAD: f64 = 3.0;
/// ...in this share of the rows: the others are pauses.
const USUAL: f64 = 0.9;
/// Steps of a coarse clock agree with the median within this share...
const EVEN: f64 = 0.25;
/// ...in this share of them.
const EVEN_SHARE: f64 = 0.8;

/// The readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Readings {
    /// Increasing from row to row.
    Rising,
    /// Increasing, shared by several rows each.
    Coarse {
        /// Step between readings.
        resolution: f64,
        /// Mean number of rows per reading.
        rows: f64,
        /// The steps are equal, unlike those of a host's stamps for rows in bursts.
        is_even: bool,
    },
    /// Near one positive value, as the time since the previous row.
    NearOne,
    /// None of these.
    Other,
}

impl Readings {
    pub fn of(numbers: &[f64]) -> Self {
        let steps = || numbers.windows(2).map(|pair| pair[1] - pair[0]);
        let count = |is: fn(f64) -> bool| steps().filter(|step| is(*step)).count() as f64;
        let (rises, falls, repeats) = (
            count(|step| step > 0.0),
            count(|step| step < 0.0),
            count(|step| step == 0.0),
        );
        if rises > 0.0 && falls <= FALLS * rises {
            return match repeats <= REPEATS * (rises + falls + repeats) {
                true => Self::Rising,
                false => coarse(numbers).unwrap_or(Self::Other),
            };
        }
        match is_near_one(numbers) {
            true => Self::NearOne,
            false => Self::Other,
        }
    }

    /// Whether they continue as a clock's.
    pub fn go_on(&self) -> bool {
        matches!(self, Self::Rising | Self::Coarse { .. })
    }
}

fn median(mut numbers: Vec<f64>) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied()
}

fn is_near_one(numbers: &[f64]) -> bool {
    // The first row has no previous row.
    let numbers = numbers.get(1..).unwrap_or_default();
    let Some(middle) = median(numbers.to_vec()) else {
        return false;
    };
    let is_usual = |number: &&f64| (middle / SPREAD..=middle * SPREAD).contains(*number);
    let usual = numbers.iter().filter(is_usual).count();
    let is_positive = middle > 0.0 && numbers.iter().all(|number| *number >= 0.0);
    is_positive && usual as f64 >= USUAL * numbers.len() as f64
}

/// Readings shared by several rows, from the rows in which they increase.
fn coarse(numbers: &[f64]) -> Option<Readings> {
    let rises: Vec<usize> = (1..numbers.len())
        .filter(|&row| numbers[row] > numbers[row - 1])
        .collect();
    let steps =
        || (rises.windows(2)).map(|pair| (numbers[pair[1]] - numbers[pair[0]], pair[1] - pair[0]));
    let resolution = median(steps().map(|(step, _)| step).collect())?;
    let is_even = |(step, _): &(f64, usize)| (step / resolution - 1.0).abs() <= EVEN;
    let even = steps().filter(is_even).count();
    let rows: usize = steps().filter(is_even).map(|(_, rows)| rows).sum();
    Some(Readings::Coarse {
        resolution,
        rows: rows as f64 / even as f64,
        is_even: even as f64 >= EVEN_SHARE * steps().count() as f64,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(reading: impl Fn(usize) -> f64) -> Readings {
        let numbers: Vec<f64> = (0..200).map(reading).collect();
        Readings::of(&numbers)
    }

    #[test]
    fn clocks_are_separated_from_other_columns() {
        assert_eq!(of(|k| 10.0 * k as f64), Readings::Rising);
        // Two blocks.
        assert_eq!(of(|k| (k % 100) as f64), Readings::Rising);
        let coarse = |rows, is_even| Readings::Coarse {
            resolution: 1.0,
            rows,
            is_even,
        };
        assert_eq!(of(|k| (k / 2) as f64), coarse(2.0, true));
        // Three rows in two readings.
        let Readings::Coarse { rows, is_even, .. } = of(|k| (2 * k / 3) as f64) else {
            panic!("coarse");
        };
        assert!(is_even && (rows - 1.5).abs() < 0.02, "{rows}");
        // Bursts of rows, as a host receives them.
        let bunched = of(|k| (k / 4 * 4 + 7 * (k / 8)) as f64);
        assert!(matches!(bunched, Readings::Coarse { is_even: false, .. }));
        assert_eq!(of(|k| 10_000.0 + (k * 7 % 11) as f64), Readings::NearOne);
        assert_eq!(of(|_| 1500.0), Readings::NearOne);
        assert_eq!(of(|_| 0.0), Readings::Other);
        assert_eq!(of(|k| (k as f64 * 0.1).sin()), Readings::Other);
    }
}
