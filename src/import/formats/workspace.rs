//! Variables of a MATLAB workspace from both versions of MAT files: their values, and the resulting columns.

use super::super::table::{Table, TableColumn};
use super::mcos::{Objects, reference};
use super::series::{self, Series};
use super::variables::Variables;
use super::{Form, FormatError, MOST_VALUES};

/// Most elements of an array of structs or objects that become columns.
const MOST_STRUCTS: usize = 64;
/// Deepest nesting of values: structs, a Dataset's storage, its signals and their buses.
const MOST_DEPTH: usize = 32;
/// Most values visited: a thousand signals with all their MATLAB properties.
const MOST_VISITS: usize = 1 << 18;

/// A value of the workspace.
pub(super) enum Value {
    /// Numbers with their sizes; the first index varies fastest.
    Numbers(Vec<usize>, Vec<f64>),
    Text(String),
    Cells(Vec<Value>),
    /// Fields with their value in every element.
    Structs(Vec<(String, Vec<Value>)>),
    /// Class of objects and their identifiers; empty if unknown.
    Objects(String, Vec<u32>),
    Other,
}

impl Value {
    /// Its numbers with their sizes, if it has any.
    pub fn numbers(&self) -> Option<(&[usize], &[f64])> {
        match self {
            Self::Numbers(sizes, numbers) if !numbers.is_empty() => Some((sizes, numbers)),
            _ => None,
        }
    }

    /// Its value, if it is a scalar.
    pub fn number(&self) -> Option<f64> {
        match self.numbers()?.1 {
            [number] => Some(*number),
            _ => None,
        }
    }

    /// Its text, if it is a non-empty one.
    pub fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) if !text.trim().is_empty() => Some(text.trim()),
            _ => None,
        }
    }

    /// Its cells; empty for other values.
    pub fn cells(&self) -> &[Value] {
        match self {
            Self::Cells(cells) => cells,
            _ => &[],
        }
    }

    /// A field of its first element.
    pub fn field(&self, name: &str) -> Option<&Value> {
        match self {
            Self::Structs(fields) => fields.iter().find(|(field, _)| field == name)?.1.first(),
            _ => None,
        }
    }

    /// The first object that it is or refers to.
    pub fn object(&self) -> Option<u32> {
        match self {
            Self::Objects(_, ids) => ids.first().copied(),
            Self::Numbers(_, numbers) => reference(numbers)?.first().copied(),
            _ => None,
        }
    }
}

struct Workspace<'a> {
    form: Form,
    objects: Option<&'a Objects>,
    variables: Variables,
    /// Numbers that may still be read: objects may refer to the same ones repeatedly.
    values: usize,
    /// Values that may still be visited.
    visits: usize,
}

pub(super) fn table(
    form: Form,
    values: Vec<(String, Value)>,
    objects: Option<Objects>,
) -> Result<Table, FormatError> {
    let mut workspace = Workspace {
        form,
        objects: objects.as_ref(),
        variables: Variables::new(form),
        values: MOST_VALUES,
        visits: MOST_VISITS,
    };
    for (name, value) in values {
        workspace.add(&name, &value, 0)?;
    }
    workspace.variables.table()
}

impl Workspace<'_> {
    /// The vectors in a value, with MATLAB's names for them.
    fn add(&mut self, name: &str, value: &Value, depth: usize) -> Result<(), FormatError> {
        let remaining = self.visits.checked_sub(1).filter(|_| depth <= MOST_DEPTH);
        self.visits =
            remaining.ok_or_else(|| self.form.broken("its values are nested without end"))?;
        match value {
            Value::Numbers(sizes, numbers) => match (reference(numbers), &sizes[..]) {
                (Some(ids), _) => self.objects(name, "unknown", &ids, depth),
                (None, &[rows, columns]) => {
                    self.charge(numbers.len())?;
                    self.variables.push(name, rows, columns, numbers);
                    Ok(())
                }
                _ => Ok(()),
            },
            Value::Structs(fields) => self.structs(name, fields, depth),
            Value::Objects(class, ids) => self.objects(name, class, ids, depth),
            _ => Ok(()),
        }
    }

    fn charge(&mut self, count: usize) -> Result<(), FormatError> {
        let remaining = self.values.checked_sub(count);
        self.values = remaining.ok_or_else(|| self.form.too_much("values"))?;
        Ok(())
    }

    fn structs(
        &mut self,
        name: &str,
        fields: &[(String, Vec<Value>)],
        depth: usize,
    ) -> Result<(), FormatError> {
        let is_simulink = ["time", "signals"]
            .iter()
            .all(|wanted| fields.iter().any(|(field, _)| field == wanted));
        for (field, values) in fields {
            for (at, value) in values.iter().enumerate().take(MOST_STRUCTS) {
                let element = match values.len() {
                    1 => format!("{name}.{field}"),
                    _ => format!("{name}({}).{field}", at + 1),
                };
                match value {
                    Value::Structs(parts) if is_simulink && field == "signals" => {
                        self.signals(&element, parts, depth + 1)?;
                    }
                    value => self.add(&element, value, depth + 1)?,
                }
            }
        }
        Ok(())
    }

    /// Simulink's structure with time: `values` of every signal under its label.
    fn signals(
        &mut self,
        name: &str,
        fields: &[(String, Vec<Value>)],
        depth: usize,
    ) -> Result<(), FormatError> {
        let elements = |wanted: &str| -> &[Value] {
            let found = fields.iter().find(|(field, _)| field == wanted);
            found.map_or(&[], |(_, values)| values)
        };
        let (values, labels) = (elements("values"), elements("label"));
        for (at, value) in values.iter().enumerate() {
            let name = match labels.get(at).and_then(Value::text) {
                Some(label) => label.to_owned(),
                None if values.len() == 1 => name.to_owned(),
                None => format!("{name}({})", at + 1),
            };
            self.add(&name, value, depth)?;
        }
        Ok(())
    }

    fn objects(
        &mut self,
        name: &str,
        class: &str,
        ids: &[u32],
        depth: usize,
    ) -> Result<(), FormatError> {
        let Some(objects) = self.objects.filter(|_| !ids.is_empty()) else {
            self.variables.object_not_read(name, class);
            return Ok(());
        };
        for (at, &id) in ids.iter().enumerate().take(MOST_STRUCTS) {
            let element = match ids.len() {
                1 => name.to_owned(),
                _ => format!("{name}({})", at + 1),
            };
            let class = objects.class(id).unwrap_or_else(|| class.to_owned());
            self.object(objects, &element, &class, id, depth)?;
        }
        Ok(())
    }

    fn object(
        &mut self,
        objects: &Objects,
        name: &str,
        class: &str,
        id: u32,
        depth: usize,
    ) -> Result<(), FormatError> {
        let property = |wanted: &str| objects.property(id, wanted);
        match class {
            "timeseries" => self.series(name, class, series::timeseries(objects, id)),
            "timetable" => self.series(name, class, series::timetable(objects, id)),
            "table" => {
                let (names, data) = (property("varnames"), property("data"));
                let (names, data) = (names.map_or(&[][..], Value::cells), data.map(Value::cells));
                for (column, value) in names.iter().zip(data.unwrap_or_default()) {
                    let column = column.text().unwrap_or_default();
                    self.add(&format!("{name}.{column}"), value, depth + 1)?;
                }
                Ok(())
            }
            "duration" | "datetime" => {
                if let Some(time_s) = series::times_s(objects, id) {
                    self.charge(time_s.len())?;
                    self.variables.push_time(name, time_s);
                }
                Ok(())
            }
            "Simulink.SimulationOutput" => match property("Data") {
                Some(data) => self.add(name, data, depth + 1),
                None => Ok(()),
            },
            "Simulink.SimulationData.Dataset" => {
                for (at, element) in series::elements(objects, id).iter().enumerate() {
                    let path = format!("{name}{{{}}}", at + 1);
                    let label = objects.property_of(Some(element), "Name");
                    let label = label.and_then(Value::text).unwrap_or(&path);
                    let name = match self.variables.has(label) {
                        true => path.as_str(),
                        false => label,
                    };
                    self.add(name, element, depth + 1)?;
                }
                Ok(())
            }
            _ => match property("Values") {
                Some(values) if class.starts_with("Simulink.SimulationData.") => {
                    self.add(name, values, depth + 1)
                }
                _ => {
                    self.variables.object_not_read(name, class);
                    Ok(())
                }
            },
        }
    }

    fn series(
        &mut self,
        name: &str,
        class: &str,
        series: Result<Series, String>,
    ) -> Result<(), FormatError> {
        let series = match series {
            Ok(series) => series,
            Err(why) => {
                self.variables
                    .object_not_read(name, &format!("{class}, {why}"));
                return Ok(());
            }
        };
        let count = series.time_s.len();
        self.charge(count * (1 + series.columns.len()))?;
        // A constant is logged once.
        if count < 2 {
            return Ok(());
        }
        let columns = series.columns.into_iter().map(|(part, unit, numbers)| {
            let name = format!("{name}{part}");
            (TableColumn { name, unit }, numbers)
        });
        self.variables
            .push_series(&series.time_s, columns.collect());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::mcos::made::{Object, cells, reference_to};
    use super::*;

    fn numbers(numbers: &[f64]) -> Value {
        Value::Numbers(vec![numbers.len(), 1], numbers.to_vec())
    }

    fn read(objects: Vec<Object>) -> Result<Table, FormatError> {
        let variable = ("x".to_owned(), reference_to(1));
        table(Form::Mat5, vec![variable], Objects::of(cells(objects)))
    }

    #[test]
    fn a_series_whose_time_does_not_fit_is_named_with_what_to_do() {
        let read = |times: &[f64]| {
            let info = vec![("Time_", numbers(times))];
            let series = vec![
                ("Data_", numbers(&[1.0, 2.0, 3.0])),
                ("TimeInfo", reference_to(2)),
            ];
            read(vec![
                ("", "timeseries", series),
                ("tsdata", "timemetadata", info),
            ])
        };
        let error = read(&[0.0, 1.0]).expect_err("no table").to_string();
        for wanted in [
            "x (an object of class timeseries, whose data are 3 by 1 and times 2)",
            "save log.mat",
        ] {
            assert!(error.contains(wanted), "{error}");
        }
        let table = read(&[0.0, 1.0, 2.0]).expect("a table");
        assert_eq!(table.columns.len(), 2);
        assert_eq!(table.columns[1].name, "x");
    }

    #[test]
    fn objects_that_hold_themselves_end() {
        let both = || vec![reference_to(1), reference_to(1)];
        let data = Value::Structs(vec![("a".to_owned(), both()), ("b".to_owned(), both())]);
        let error = read(vec![("Simulink", "SimulationOutput", vec![("Data", data)])]);
        assert!(
            matches!(error, Err(FormatError::Broken { .. })),
            "{error:?}"
        );
    }
}
