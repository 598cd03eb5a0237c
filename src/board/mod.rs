//! The board room: everything between a serial device and validated samples.

pub mod text_lines;

pub mod faults;
