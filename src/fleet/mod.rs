//! Many diagnoses side by side: their documents as flat tables, and each unit compared with the population.
//!
//! [`Document`] reads `motorlab-diagnosis/2` and `/3`; [`tables`] makes rows of many documents; [`Population`] finds
//! units with a recurring effect or an outlying parameter, and drift. Nothing is fitted here: every figure is from a
//! document.

mod date;
mod determined;
mod document;
mod identified;
#[cfg(feature = "parquet")]
mod parquet;
mod population;
mod recurring;
mod robust;
mod table;
mod tables;

pub use document::{Cause, Damaged, Document, Interval, MOST_BYTES};
#[cfg(feature = "parquet")]
pub use parquet::write_table;
pub use population::{
    Drift, FEWEST_DATES, FEWEST_UNITS, LEAST_OUTLIER_SCORE, Number, Outlier, Population,
    SIGNIFICANT, Unit,
};
pub use recurring::Recurring;
pub use table::{Column, Table, Values};
pub use tables::{Tables, tables};
