//! Many diagnoses side by side: their documents as flat tables, and each unit compared with the population.
//!
//! [`Document`] is a document `motorlab-diagnosis/2` or `/3`; [`tables`] makes rows of many of them; [`Population`]
//! finds units with a recurring effect or an outlying parameter, and drift. Nothing is fitted here: every figure is a document's.

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
    Drift, FEWEST_DATES, FEWEST_UNITS, Number, OUTSTANDING, Outlier, Population, SIGNIFICANT, Unit,
};
pub use recurring::Recurring;
pub use table::{Column, Table, Values};
pub use tables::{Tables, tables};
