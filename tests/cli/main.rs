//! The command line as a whole: bad input, limits, outputs, JSON documents.

#[path = "../support/mod.rs"]
mod support;

mod asked_wrongly;
mod bad_input;
mod completions;
mod config_file;
mod hints;
mod hostile_names;
mod input_limits;
mod json_documents;
mod output_files;
mod profile_length;
mod threads;
