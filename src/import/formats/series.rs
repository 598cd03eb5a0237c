//! MATLAB's time series objects: timeseries, timetable and the elements of Simulink's Dataset.
//!
//! Property names are those of files of MATLAB R2019a to R2025b.

use super::mcos::Objects;
use super::variables::MOST_OF_A_MATRIX;
use super::workspace::Value;

/// Samples with their time.
pub(super) struct Series {
    /// In s; for dates since 1970.
    pub time_s: Vec<f64>,
    /// Suffix of the name, unit, and a value for each time.
    pub columns: Vec<(String, Option<String>, Vec<f64>)>,
}

/// The samples of a `timeseries`, or why it cannot be read.
pub(super) fn timeseries(objects: &Objects, id: u32) -> Result<Series, String> {
    let property = |name: &str| objects.property(id, name);
    let is = |value: Option<&Value>| value.and_then(Value::number) == Some(1.0);
    // To Workspace keeps the samples in streaming storage.
    let storage = property("Storage_");
    let streamed = objects.property_of(storage, "Data");
    let (data, is_time_first) = match (property("Data_"), streamed) {
        (Some(data), _) if data.numbers().is_some() => (data, is(property("IsTimeFirst_"))),
        (_, Some(data)) => (data, is(objects.property_of(storage, "IsTimeStorageFirst"))),
        _ => return Err("without numbers as its data".to_owned()),
    };
    let plain = data.numbers().filter(|_| data.object().is_none());
    let (sizes, numbers) = plain.ok_or("whose data are objects themselves")?;
    let info = property("TimeInfo");
    let time = |name: &str| objects.property_of(info, name);
    let unit = time("Units").and_then(Value::text).unwrap_or("seconds");
    let unit_s = seconds_in(unit).ok_or_else(|| format!("whose time is in {unit}"))?;
    let listed = [time("Time_"), property("Time_")];
    let listed = listed.into_iter().flatten().find_map(Value::numbers);
    let mut time_s: Vec<f64> = match (listed, time("Start_"), time("Increment_")) {
        (Some((_, times)), _, _) => times.to_vec(),
        (None, Some(start), Some(step)) => {
            let (start, step) = start.number().zip(step.number()).ok_or("without a time")?;
            let along = match is_time_first {
                true => sizes.first(),
                false => sizes.last(),
            };
            let count = *along.ok_or("without data")?;
            (0..count).map(|k| start + step * k as f64).collect()
        }
        _ => return Err("without a time".to_owned()),
    };
    time_s.iter_mut().for_each(|time| *time *= unit_s);
    let info = property("DataInfo");
    let unit = objects.property_of(info, "Units");
    let unit = unit.and_then(Value::text).map(str::to_owned);
    let mut series = Series::new(time_s)?;
    series.push("", unit, sizes, numbers, is_time_first)?;
    Ok(series)
}

/// The numeric variables of a `timetable`, or why it cannot be read.
pub(super) fn timetable(objects: &Objects, id: u32) -> Result<Series, String> {
    let saved = objects.property(id, "any").ok_or("of an unknown version")?;
    let cells = |name: &str| saved.field(name).map_or(&[][..], Value::cells);
    let (names, units) = (cells("varNames"), cells("varUnits"));
    let mut sizes = cells("data").iter().filter_map(Value::numbers);
    let rows = sizes.next().and_then(|(sizes, _)| sizes.first().copied());
    let rows = rows.ok_or("without a variable of numbers")?;
    let times = saved.field("rowTimes").ok_or("without a time")?;
    let time_s = match times.object() {
        Some(times) => times_s(objects, times),
        None => regular_s(objects, times, rows),
    };
    let mut series = Series::new(time_s.ok_or("whose time is not read")?)?;
    for (at, (name, data)) in names.iter().zip(cells("data")).enumerate() {
        if let Some((sizes, numbers)) = data.numbers() {
            let part = format!(".{}", name.text().unwrap_or_default());
            let unit = units.get(at).and_then(Value::text).map(str::to_owned);
            series.push(&part, unit, sizes, numbers, true)?;
        }
    }
    Ok(series)
}

/// Times with a start and a step or a rate.
fn regular_s(objects: &Objects, times: &Value, rows: usize) -> Option<Vec<f64>> {
    let start_s = *times_s(objects, times.field("origin")?.object()?)?.first()?;
    let rate_hz = times.field("sampleRate").and_then(Value::number);
    let step = times.field("stepSize").and_then(Value::object);
    let step_s = match rate_hz.filter(|rate| *rate > 0.0) {
        Some(rate_hz) => rate_hz.recip(),
        None => *times_s(objects, step?)?.first()?,
    };
    Some((0..rows).map(|k| start_s + step_s * k as f64).collect())
}

/// Times of a `duration` in s; of a `datetime` in s since 1970.
pub(super) fn times_s(objects: &Objects, id: u32) -> Option<Vec<f64>> {
    let found = ["millis", "data"]
        .into_iter()
        .find_map(|name| objects.property(id, name)?.numbers());
    Some(found?.1.iter().map(|ms| ms / 1e3).collect())
}

/// The elements of a Dataset, which are in its storage, as both save themselves.
pub(super) fn elements(objects: &Objects, id: u32) -> &[Value] {
    let saved =
        |object: Option<&Value>, field: &str| objects.property_of(object, "any")?.field(field);
    let own = objects.property(id, "any");
    let storage = own.and_then(|own| own.field("Storage"));
    saved(storage, "Elements").map_or(&[], Value::cells)
}

/// Seconds per unit of a timeseries.
fn seconds_in(unit: &str) -> Option<f64> {
    Some(match unit.to_lowercase().as_str() {
        "weeks" => 604_800.0,
        "days" => 86_400.0,
        "hours" => 3600.0,
        "minutes" => 60.0,
        "seconds" | "s" => 1.0,
        "milliseconds" | "ms" => 1e-3,
        "microseconds" | "us" => 1e-6,
        "nanoseconds" | "ns" => 1e-9,
        _ => return None,
    })
}

impl Series {
    fn new(time_s: Vec<f64>) -> Result<Self, String> {
        match time_s.iter().all(|time| time.is_finite()) {
            true => Ok(Self {
                time_s,
                columns: Vec::new(),
            }),
            false => Err("whose time is no number somewhere".to_owned()),
        }
    }

    /// Samples of any shape, along the first dimension or the last, with a column for each element.
    fn push(
        &mut self,
        part: &str,
        unit: Option<String>,
        sizes: &[usize],
        numbers: &[f64],
        is_time_first: bool,
    ) -> Result<(), String> {
        let count = self.time_s.len();
        let (first, last) = (sizes.first() == Some(&count), sizes.last() == Some(&count));
        let (is_time_first, of_a_sample) = match (first, last, sizes) {
            (true, _, [_, rest @ ..]) if is_time_first || !last => (true, rest),
            (_, true, [rest @ .., _]) => (false, rest),
            _ => {
                let sizes: Vec<String> = sizes.iter().map(usize::to_string).collect();
                let sizes = sizes.join(" by ");
                return Err(format!("whose data are {sizes} and times {count}"));
            }
        };
        let elements: usize = of_a_sample.iter().product();
        if numbers.len() != elements.saturating_mul(count) || count == 0 {
            return Err("whose data contradict their sizes".to_owned());
        }
        if elements > MOST_OF_A_MATRIX {
            return Err(format!("of {elements} values a sample"));
        }
        for at in 0..elements {
            let column: Vec<f64> = match is_time_first {
                true => numbers[at * count..(at + 1) * count].to_vec(),
                false => numbers.iter().skip(at).step_by(elements).copied().collect(),
            };
            let place = match elements {
                1 => String::new(),
                _ => subscript(at, of_a_sample, is_time_first),
            };
            self.columns
                .push((format!("{part}{place}"), unit.clone(), column));
        }
        Ok(())
    }
}

/// MATLAB's notation of an element of every sample: `(:,2)`, `(1,3,:)`.
fn subscript(mut at: usize, sizes: &[usize], is_time_first: bool) -> String {
    let mut places: Vec<String> = Vec::new();
    for size in sizes {
        places.push((at % size + 1).to_string());
        at /= size;
    }
    let end = if is_time_first { 0 } else { places.len() };
    places.insert(end, ":".to_owned());
    format!("({})", places.join(","))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(sizes: &[usize], times: usize, is_time_first: bool) -> Result<Vec<String>, String> {
        let mut series = Series::new((0..times).map(|k| k as f64).collect())?;
        let count = sizes.iter().product();
        let numbers: Vec<f64> = (0..count).map(|k: usize| k as f64).collect();
        series.push("y", None, sizes, &numbers, is_time_first)?;
        let columns = series.columns.iter();
        Ok(columns
            .map(|(name, _, x)| format!("{name} {x:?}"))
            .collect())
    }

    #[test]
    fn samples_lie_along_the_first_size_or_the_last() {
        let found = columns(&[3, 2], 3, true).expect("columns");
        assert_eq!(found, ["y(:,1) [0.0, 1.0, 2.0]", "y(:,2) [3.0, 4.0, 5.0]"]);
        let found = columns(&[2, 1, 3], 3, false).expect("columns");
        assert_eq!(
            found,
            ["y(1,1,:) [0.0, 2.0, 4.0]", "y(2,1,:) [1.0, 3.0, 5.0]"]
        );
        assert_eq!(
            columns(&[1, 1, 3], 3, false).expect("one"),
            ["y [0.0, 1.0, 2.0]"]
        );
        // For a square the stated dimension applies; else the one whose size matches.
        assert_eq!(
            columns(&[2, 2], 2, false).expect("two")[0],
            "y(1,:) [0.0, 2.0]"
        );
        assert_eq!(
            columns(&[2, 2], 2, true).expect("two")[0],
            "y(:,1) [0.0, 1.0]"
        );
        assert_eq!(
            columns(&[3, 1], 3, false).expect("one"),
            ["y [0.0, 1.0, 2.0]"]
        );
    }

    #[test]
    fn sizes_that_do_not_fit_are_errors() {
        assert_eq!(
            columns(&[3, 1], 2, true),
            Err("whose data are 3 by 1 and times 2".to_owned())
        );
        assert_eq!(
            columns(&[2, 100], 2, true),
            Err("of 100 values a sample".to_owned())
        );
        assert!(Series::new(vec![0.0, f64::NAN]).is_err());
    }

    #[test]
    fn units_of_time_of_matlab_are_recognized() {
        assert_eq!(seconds_in("Hours"), Some(3600.0));
        assert_eq!(seconds_in("milliseconds"), Some(1e-3));
        assert_eq!(seconds_in("fortnights"), None);
    }
}
