//! Queries of DuckDB that a user copies, over the tables that were written.

use crate::report::Page;

/// Where the tables are, for the queries.
#[derive(Debug, Clone)]
pub struct Names {
    /// Rows a diagnosis.
    pub diagnoses: String,
    /// Rows a cause.
    pub causes: String,
    /// Rows a number.
    pub numbers: String,
}

/// Puts the queries on the page.
pub(super) fn put(page: &mut Page, names: &Names) {
    page.section("To ask further");
    page.paragraph("DuckDB reads the tables where they are: duckdb -c \"QUERY\".");
    let quoted = |name: &str| format!("'{}'", name.replace('\'', "''"));
    let [diagnoses, causes, numbers] =
        [&names.diagnoses, &names.causes, &names.numbers].map(|name| quoted(name));
    for query in [
        format!(
            "SELECT verdict, count(*) AS diagnoses, avg(probability) AS probability\nFROM {diagnoses} GROUP BY verdict ORDER BY diagnoses DESC;"
        ),
        format!(
            "-- how likely each effect is over all recordings, whatever the verdicts name\nSELECT effect, avg(probability) AS probability, avg(inclusion) AS inclusion, count(DISTINCT unit) AS units\nFROM {causes} GROUP BY effect ORDER BY probability DESC LIMIT 20;"
        ),
        format!(
            "-- units by how far they lie from the median\nWITH unit AS (SELECT unit, name, median(value) AS value FROM {numbers} WHERE cause IS NULL OR named = 1 GROUP BY unit, name),\n     middle AS (SELECT name, median(value) AS centre, 1.4826 * mad(value) AS sigma FROM unit GROUP BY name)\nSELECT unit, name, value, centre, (value - centre) / sigma AS z\nFROM unit JOIN middle USING (name) WHERE sigma > 0 ORDER BY abs(z) DESC LIMIT 20;"
        ),
        format!(
            "-- a number over time\nSELECT unit, started, value, lo95, hi95 FROM {numbers}\nWHERE name = 'coulomb_friction_nm' ORDER BY unit, started;"
        ),
        format!(
            "SELECT document, finding_ids, sentence FROM {diagnoses} WHERE verdict = 'bad_recording';"
        ),
    ] {
        page.verbatim(&query);
    }
}
