//! Two thousand diagnosis documents as tables and as the fleet page: time, and size of the page.
//!
//! `cargo bench --bench tabulate` (all features, for Parquet too)

use std::fs;
use std::time::Instant;

use motorlab::fleet::{Document, Population, tables};
use motorlab::report::fleet::{Names, page};
use rayon::prelude::*;

const DOCUMENTS: usize = 2_000;
/// Time limit in s.
const MOST_S: f64 = 5.0;

fn main() {
    let folder = tempfile::tempdir().expect("a folder");
    let interval = |value: f64| {
        format!(
            "{{\"value\":{value},\"lo95\":{},\"hi95\":{},\"unit\":\"\"}}",
            value - 0.02,
            value + 0.02
        )
    };
    let paths: Vec<_> = (0..DOCUMENTS)
        .map(|k| {
            let scatter = |n: usize| (k * n % 101) as f64 / 101.0;
            let causes: Vec<String> = (0..30)
                .map(|c| format!("{{\"effect\":\"effect_{c}\",\"stage\":\"driver\",\"inclusion\":0.05,\"at_bound\":false,\"parameters\":{{\"volts\":{}}}}}", interval(scatter(c + 3))))
                .collect();
            let text = format!(
                "{{\"shape\":\"motorlab-diagnosis/3\",\"verdict\":\"effect\",\"sentence\":\"Backlash\",\"probability\":0.9,\"effects\":[\"effect_0\"],\
                 \"causes\":[{}],\"where\":{{\"stage\":\"driver\"}},\"gap\":null,\"base\":{{\"coulomb_friction_nm\":{},\"inertia_kg_m2\":{},\"back_emf_v_s_per_rad\":{},\"viscous_friction_nm_s_per_rad\":{}}},\
                 \"steps\":[{}],\"data\":[],\"next_experiment\":null,\"elapsed_s\":0.5,\"runs\":[{{\"path\":\"r\",\"role\":\"diagnosed\",\"unit\":\"U{k}\",\"started\":\"2026-03-{:02}T00:00:00Z\",\"samples\":500,\"sample_time_s\":0.003,\"duration_s\":1.5}}]}}",
                causes.join(","), interval(1.0 + scatter(7)), interval(1.0 + scatter(11)), interval(1.0 + scatter(13)), interval(1.0 + scatter(17)), vec!["0"; 2000].join(","), 1 + k % 28
            );
            let path = folder.path().join(format!("{k}.json"));
            fs::write(&path, text).expect("written");
            path
        })
        .collect();
    let start = Instant::now();
    let documents: Vec<Document> = paths
        .par_iter()
        .map(|path| Document::read(path).expect("a diagnosis"))
        .collect();
    let read_s = start.elapsed().as_secs_f64();
    let tables = tables(&documents);
    let csv: usize = [&tables.diagnoses, &tables.causes, &tables.numbers]
        .map(|table| table.to_csv().expect("a table").len())
        .iter()
        .sum();
    let tabulated_s = start.elapsed().as_secs_f64();
    let names = Names {
        diagnoses: "fleet.parquet".to_owned(),
        causes: "causes.parquet".to_owned(),
        numbers: "numbers.parquet".to_owned(),
    };
    let html = page(&documents, &[], &Population::of(&documents), &names);
    let all_s = start.elapsed().as_secs_f64();
    println!(
        "{DOCUMENTS} documents: read {read_s:.2} s, as tables ({:.1} MB of CSV) {tabulated_s:.2} s, as a page too {all_s:.2} s; the page has {:.2} MB",
        csv as f64 / 1e6,
        html.len() as f64 / 1e6
    );
    assert!(tabulated_s < MOST_S, "it may take {MOST_S} s");
}
