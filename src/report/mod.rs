//! Output for people: plots, offline HTML files, the terminal.
//!
//! A [`Figure`] is the content of a plot; [`svg`] renders it for files and pages, [`terminal`] as text. A [`Page`]
//! gathers text, tables and figures into one self-contained HTML file with interactive figures (uPlot, inlined) and
//! sortable tables; without scripts the drawings remain.

mod bars;
mod cell;
pub mod comparison;
pub mod demo;
pub mod diagnosis;
mod escape;
mod explore;
pub mod figure;
pub mod fleet;
mod frame;
mod html;
pub mod isolability;
mod legend;
mod matrix;
pub mod number;
mod scale;
mod strip;
pub mod svg;
pub mod table;
pub mod terminal;
mod thumbnail;

pub use bars::{Bar, Bars, Scale};
pub use cell::Cell;
pub use escape::escaped;
pub use figure::{Band, Figure, Panel, Series, Stroke};
pub use html::Page;
pub use matrix::Matrix;
pub use scale::AxisScale;
pub use strip::{Dot, Strip};
pub use svg::Size;
