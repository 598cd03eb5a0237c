//! The documentation is consistent: links, commands, glossary and vocabulary.

#[path = "../support/mod.rs"]
mod support;

mod glossary;
mod guarantees;
mod pages;
mod vocabulary;
