//! Many diagnoses side by side: their documents read again, laid out as flat tables, and each unit held against the population.
//!
//! [`Document`] is what is read of a `motorlab-diagnosis/2`; [`tables`] lays many of them out as rows; [`Population`]
//! says which units stand out by which number, and what drifts. Nothing is fitted here: every figure is a document's.

mod date;
mod document;
#[cfg(feature = "parquet")]
mod parquet;
mod population;
mod robust;
mod table;
mod tables;

pub use document::{Cause, Damaged, Document, Interval, MOST_BYTES};
#[cfg(feature = "parquet")]
pub use parquet::write_table;
pub use population::{
    Drift, FEWEST_DATES, FEWEST_UNITS, Number, OUTSTANDING, Population, SIGNIFICANT, Standing, Unit,
};
pub use table::{Column, Table, Values};
pub use tables::{Tables, tables};
