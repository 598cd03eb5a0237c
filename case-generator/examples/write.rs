//! Writes cases to a directory, labels to a file of their own:
//!
//! ```text
//! cargo run -p case-generator --release --example write -- --seed 1 --count 40 --kind singles DIR --labels FILE
//! ```
//!
//! `--kind` is mixed, singles, pairs, none, outside, an effect's id, or two ids joined by `+`.
//! `--other-motors` draws motors unlike the handout's; `--wander X` multiplies the wander.
//! A case's directory holds motor.toml, run1.csv, run2.csv, run3.csv and unseen.csv.

use std::error::Error;
use std::fs;
use std::path::PathBuf;

use case_generator::{Kind, Mix, Options, generate_with, plan};

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
            "--wander" => options.wander_scale = value()?.parse()?,
            "--other-motors" => options.other_motors = true,
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
    let mut all = serde_json::Map::new();
    for (k, (seed, kind)) in planned.iter().enumerate() {
        let case = generate_with(*seed, kind, &options);
        let name = format!("case-{:04}", k + 1);
        let folder = directory.join(&name);
        fs::create_dir_all(&folder)?;
        fs::write(folder.join("motor.toml"), case.nominal.to_toml())?;
        for (n, run) in case.runs.iter().enumerate() {
            fs::write(folder.join(format!("run{}.csv", n + 1)), run.to_csv())?;
        }
        fs::write(folder.join("unseen.csv"), case.unseen_run.to_csv())?;
        all.insert(name, serde_json::to_value(&case.label)?);
    }
    if let Some(labels) = labels {
        fs::write(labels, serde_json::to_string_pretty(&all)?)?;
    }
    Ok(())
}
