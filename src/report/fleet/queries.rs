//! DuckDB queries over the written tables.

use crate::report::Page;

/// Paths of the tables in the queries.
#[derive(Debug, Clone)]
pub struct Names {
    /// Rows per diagnosis.
    pub diagnoses: String,
    /// Rows per cause.
    pub causes: String,
    /// Rows per parameter.
    pub numbers: String,
}

pub(super) fn put(page: &mut Page, names: &Names) {
    page.section("Queries");
    page.paragraph("DuckDB reads the tables where they are: duckdb -c \"QUERY\".");
    let quoted = |name: &str| format!("'{}'", name.replace('\'', "''"));
    let [diagnoses, causes, numbers] =
        [&names.diagnoses, &names.causes, &names.numbers].map(|name| quoted(name));
    for query in [
        format!(
            "SELECT verdict, count(*) AS diagnoses, avg(probability) AS probability\nFROM {diagnoses} GROUP BY verdict ORDER BY diagnoses DESC;"
        ),
        format!(
            "-- inclusion probability of each effect, the mean of the recordings that list it\nSELECT effect, avg(inclusion) AS inclusion, avg(probability) AS probability, count(DISTINCT unit) AS units\nFROM {causes} GROUP BY effect ORDER BY inclusion DESC LIMIT 20;"
        ),
        format!(
            "-- units by their distance from the median\nWITH unit AS (SELECT unit, name, median(value) AS value FROM {numbers} WHERE cause IS NULL OR named = 1 GROUP BY unit, name),\n     middle AS (SELECT name, median(value) AS centre, 1.4826 * mad(value) AS sigma FROM unit GROUP BY name)\nSELECT unit, name, value, centre, (value - centre) / sigma AS z\nFROM unit JOIN middle USING (name) WHERE sigma > 0 ORDER BY abs(z) DESC LIMIT 20;"
        ),
        format!(
            "-- a parameter over time\nSELECT unit, started, value, lo95, hi95 FROM {numbers}\nWHERE name = 'coulomb_friction_nm' ORDER BY unit, started;"
        ),
        format!(
            "SELECT document, finding_ids, sentence FROM {diagnoses} WHERE verdict = 'bad_recording';"
        ),
    ] {
        page.verbatim(&query);
    }
}
