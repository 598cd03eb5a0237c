//! Writes cases to a directory, labels to a separate file:
//!
//! ```text
//! cargo run -p case-generator --release --example write -- --seed 1 --count 40 --kind singles DIR --labels FILE
//! ```
//!
//! `--kind` is mixed, singles, pairs, none, outside (or unknown), an effect's id, or two ids joined by `+`.
//! `--other-motors` draws motors unlike the handout's; `--random-torque X` multiplies the random torque;
//! `--friction-elsewhere` draws the division of friction between motor and load, if there are two bodies. A case's
//! directory has motor.toml (nominal), run1.csv (step at 30 ms), run2.csv (step at 3 ms), run3.csv (reversing at 3
//! ms, 15 s) and unseen.csv (another reversing run).

use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{fs, io, thread};

use serde_json::Value;

use case_generator::{Case, Kind, Mix, Options, generate_with, plan};

fn main() -> Result<(), Box<dyn Error>> {
    let mut seed = 1;
    let mut count = 10;
    let mut kind = "mixed".to_owned();
    let mut directory = None;
    let mut labels = None;
    let mut options = Options::default();
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word} needs a value"));
        match word.as_str() {
            "--seed" => seed = value()?.parse()?,
            "--count" => count = value()?.parse()?,
            "--kind" => kind = value()?,
            "--labels" => labels = Some(PathBuf::from(value()?)),
            "--random-torque" => options.random_torque_scale = value()?.parse()?,
            "--other-motors" => options.other_motors = true,
            "--friction-elsewhere" => options.friction_elsewhere = true,
            _ => directory = Some(PathBuf::from(word)),
        }
    }
    let directory = directory.ok_or("say the directory to write to")?;
    let planned: Vec<(u64, Kind)> = match kind.parse::<Mix>() {
        Ok(mix) => plan(count, seed, mix),
        Err(_) => {
            let kind: Kind = kind.parse()?;
            plan(count, seed, Mix::None)
                .into_iter()
                .map(|(seed, _)| (seed, kind.clone()))
                .collect()
        }
    };
    let next = AtomicUsize::new(0);
    let write = || -> Result<Vec<(String, Value)>, String> {
        let mut written = Vec::new();
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            let Some((seed, kind)) = planned.get(k) else {
                return Ok(written);
            };
            let case = generate_with(*seed, kind, &options);
            let name = format!("case-{:04}", k + 1);
            write_case(&directory.join(&name), &case).map_err(|error| error.to_string())?;
            let label = serde_json::to_value(&case.label).map_err(|error| error.to_string())?;
            written.push((name, label));
        }
    };
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let written: Vec<_> = thread::scope(|scope| {
        let threads: Vec<_> = (0..cores).map(|_| scope.spawn(write)).collect();
        threads.into_iter().map(|thread| thread.join()).collect()
    });
    let mut all = BTreeMap::new();
    for part in written {
        all.extend(part.map_err(|_| "a thread died")??);
    }
    if let Some(labels) = labels {
        fs::write(labels, serde_json::to_string_pretty(&all)?)?;
    }
    Ok(())
}

fn write_case(folder: &Path, case: &Case) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    fs::write(folder.join("motor.toml"), case.nominal.to_toml())?;
    for (n, run) in case.runs.iter().enumerate() {
        fs::write(folder.join(format!("run{}.csv", n + 1)), run.to_csv())?;
    }
    fs::write(folder.join("unseen.csv"), case.unseen_run.to_csv())
}
