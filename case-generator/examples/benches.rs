//! Writes recordings for `tests/thorough/score`:
//!
//! ```text
//! cargo run -p case-generator --release --example benches -- breadth --seed 1 --count 40 DIR
//! cargo run -p case-generator --release --example benches -- chosen SPEC.json DIR
//! ```
//!
//! `breadth` writes the cases of `motorlab blind make --breadth` of the same seed and count:
//! DIR/case-0001/motor.toml, run1.csv and so on, unseen.csv; DIR/truth.json has the label and the bench of each case
//! (family, protocol, random load, stated tolerance). `chosen` writes one run for each entry of the JSON object in
//! SPEC.json, under the entry's name (`case_generator::Chosen` has the keys of an entry), and DIR/visible.json: the
//! residual of its effects after re-identified parameters, in counts.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use serde_json::{Value, json};

use case_generator::breadth::{BenchCase, generate_bench, plan_breadth};
use case_generator::{Chosen, record_chosen};

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["breadth", "--seed", seed, "--count", count, directory] => {
            breadth(seed.parse()?, count.parse()?, Path::new(directory))
        }
        ["chosen", spec, directory] => chosen(&PathBuf::from(spec), Path::new(directory)),
        _ => Err("say breadth --seed N --count N DIR, or chosen SPEC.json DIR".into()),
    }
}

fn breadth(seed: u64, count: usize, directory: &Path) -> Result<(), Box<dyn Error>> {
    let planned = plan_breadth(count, seed);
    let written = on_all_cores(planned.len(), |k| {
        let (seed, hides, protocol) = planned[k];
        let name = format!("case-{:04}", k + 1);
        let made = generate_bench(seed, hides, protocol);
        write_case(&directory.join(&name), &made).map_err(|error| error.to_string())?;
        let truth = json!({"label": made.case.label, "bench": made.bench});
        Ok((name, truth))
    })?;
    fs::write(
        directory.join("truth.json"),
        serde_json::to_string_pretty(&written)?,
    )?;
    Ok(())
}

fn chosen(spec: &Path, directory: &Path) -> Result<(), Box<dyn Error>> {
    let entries: BTreeMap<String, Chosen> = serde_json::from_str(&fs::read_to_string(spec)?)?;
    let entries: Vec<(String, Chosen)> = entries.into_iter().collect();
    let visible = on_all_cores(entries.len(), |k| {
        let (name, chosen) = &entries[k];
        let made = record_chosen(chosen)?;
        let file = directory.join(name);
        let folder = file.parent().unwrap_or(directory);
        fs::create_dir_all(folder)
            .and_then(|()| fs::write(&file, made.run.to_csv()))
            .map_err(|error| format!("{}: {error}", file.display()))?;
        Ok((name.clone(), json!(made.beyond_refit_counts)))
    })?;
    fs::write(
        directory.join("visible.json"),
        serde_json::to_string_pretty(&visible)?,
    )?;
    Ok(())
}

/// Results of the function for 0 to `count`, by name, in parallel.
fn on_all_cores(
    count: usize,
    make: impl Fn(usize) -> Result<(String, Value), String> + Sync,
) -> Result<BTreeMap<String, Value>, String> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut made = Vec::new();
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            if k >= count {
                return Ok(made);
            }
            made.push(make(k)?);
        }
    };
    let cores = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| {
        let threads: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        let mut all = BTreeMap::new();
        for thread in threads {
            let part: Result<Vec<(String, Value)>, String> =
                thread.join().map_err(|_| "a thread panicked".to_owned())?;
            all.extend(part?);
        }
        Ok(all)
    })
}

fn write_case(folder: &Path, made: &BenchCase) -> std::io::Result<()> {
    fs::create_dir_all(folder)?;
    fs::write(folder.join("motor.toml"), &made.motor_file)?;
    for (n, run) in made.case.runs.iter().enumerate() {
        fs::write(folder.join(format!("run{}.csv", n + 1)), run.to_csv())?;
    }
    fs::write(folder.join("unseen.csv"), made.case.unseen_run.to_csv())
}
