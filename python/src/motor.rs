//! A motor: the keys of a motor file.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;

use motorlab::cli::Failure;
use motorlab::hint::{Hinted, In, parted};
use motorlab::motor::catalogue::EffectError;
use motorlab::motor::{self, ActiveEffect, Model, Parameters, plausible};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;

use crate::failure::{raised, refused};

/// A motor.
#[pyclass(module = "motorlab._motorlab", eq, from_py_object)]
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Motor {
    pub(crate) inner: motor::Motor,
}

#[pymethods]
impl Motor {
    /// The lab handout's motor.
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// The keys of a motor file, in its order.
    #[staticmethod]
    fn keys() -> Vec<&'static str> {
        Parameters::KEYS.to_vec()
    }

    /// Reads a motor file; also the keys that it leaves to the handout.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<(Self, Vec<&'static str>)> {
        let read = motor::read_motor_and_lacking(&path);
        let (inner, lacking) =
            read.map_err(|error| raised(py, &Failure::input(error).at(&path)))?;
        Ok((Self { inner }, lacking))
    }

    /// Writes a motor file, whole or not at all.
    fn save(&self, py: Python<'_>, path: PathBuf, overwrite: bool) -> PyResult<()> {
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => std::path::Path::new("."),
        };
        let written = tempfile::NamedTempFile::new_in(folder).and_then(|mut file| {
            file.write_all(self.inner.to_toml().as_bytes())?;
            file.as_file().sync_all()?;
            let persisted = match overwrite {
                true => file.persist(&path),
                false => file.persist_noclobber(&path),
            };
            persisted.map(|_| ()).map_err(|error| error.error)
        });
        written.map_err(|error| match error.kind() {
            std::io::ErrorKind::AlreadyExists => refused(
                py,
                Hinted::new(
                    format!("{} exists and is not overwritten", path.display()),
                    "name another file, or give overwrite=True",
                ),
            ),
            _ => raised(
                py,
                &Failure::device(In::new(path.display().to_string(), error)).at(&path),
            ),
        })
    }

    /// Reads the text of a motor file.
    #[staticmethod]
    fn from_toml(py: Python<'_>, text: &str) -> PyResult<Self> {
        let inner = motor::Motor::from_toml(text).map_err(|error| refused(py, error))?;
        Ok(Self { inner })
    }

    fn to_toml(&self) -> String {
        self.inner.to_toml()
    }

    fn get(&self, key: &str) -> PyResult<f64> {
        let value = self.inner.parameters.get(key);
        value.ok_or_else(|| PyKeyError::new_err(key.to_owned()))
    }

    /// Sets a parameter, in the unit of its name.
    fn set(&mut self, py: Python<'_>, key: &str, value: f64) -> PyResult<()> {
        set(&mut self.inner, key, value).map_err(|error| refused(py, error))
    }

    fn tolerance(&self) -> BTreeMap<String, f64> {
        self.inner.tolerance.clone()
    }

    /// Sets the relative one-sigma tolerance of a key; `None` takes it out.
    fn set_tolerance(&mut self, py: Python<'_>, key: &str, sigma: Option<f64>) -> PyResult<()> {
        let Some(sigma) = sigma else {
            self.inner.tolerance.remove(key);
            return Ok(());
        };
        let text = format!("[tolerance]\n{key:?} = {}", number(sigma));
        let read = read(&text).map_err(|error| refused(py, error))?;
        self.inner.tolerance.extend(read.tolerance);
        Ok(())
    }

    /// The effects that are part of the model, with their parameters.
    fn effects(&self) -> BTreeMap<&'static str, BTreeMap<&'static str, f64>> {
        let of = |effect: &ActiveEffect| {
            let parameters = effect.parameters();
            parameters
                .map(|(number, value)| (number.key, value))
                .collect()
        };
        let effects = self.inner.effects.iter();
        effects
            .map(|effect| (effect.kind().id, of(effect)))
            .collect()
    }

    /// Puts an effect in; what is not given has its default for this motor.
    fn set_effect(
        &mut self,
        py: Python<'_>,
        id: &str,
        parameters: BTreeMap<String, f64>,
    ) -> PyResult<()> {
        set_effect(&mut self.inner, id, &parameters).map_err(|error| refused(py, error))
    }

    /// Takes an effect out; whether it was there.
    fn remove_effect(&mut self, id: &str) -> bool {
        self.inner.effects.remove(id)
    }
}

/// Sets one parameter of a motor, as a motor file would.
pub(crate) fn set(motor: &mut motor::Motor, key: &str, value: f64) -> Result<(), Hinted> {
    match motor.parameters.get_mut(key) {
        Some(slot) if plausible::of_parameter(key).holds(value) => {
            *slot = value;
            Ok(())
        }
        // The motor file's own words for what is wrong.
        _ => read(&format!("{key:?} = {}", number(value))).map(|_| ()),
    }
}

/// Puts an effect into a motor.
pub(crate) fn set_effect(
    motor: &mut motor::Motor,
    id: &str,
    parameters: &BTreeMap<String, f64>,
) -> Result<(), EffectError> {
    let values = parameters.iter().map(|(key, value)| (key.as_str(), *value));
    let effect = ActiveEffect::from_keys(id, values, &motor.parameters)?;
    motor.effects.set(effect);
    Ok(())
}

/// Reads lines of a motor file; what is wrong is said without a line number.
fn read(text: &str) -> Result<motor::Motor, Hinted> {
    motor::Motor::from_toml(text).map_err(|error| {
        let error = error.to_string();
        let (what, hint) = parted(&error);
        let what = match what.split_once(": ") {
            Some((line, rest)) if line.starts_with("line ") => rest,
            _ => what,
        };
        Hinted::new(what, hint.unwrap_or("Motor().save(PATH) writes every key"))
    })
}

/// A number as TOML has it.
fn number(value: f64) -> String {
    format!("{value:?}").to_lowercase()
}

/// The order of a model by its name on the command line.
pub(crate) fn model_of(py: Python<'_>, name: &str) -> PyResult<Model> {
    match name {
        "first-order" => Ok(Model::FirstOrder),
        "second-order" => Ok(Model::SecondOrder),
        other => Err(refused(
            py,
            Hinted::new(
                format!("model is '{other}'"),
                "it is 'first-order' or 'second-order'",
            ),
        )),
    }
}
