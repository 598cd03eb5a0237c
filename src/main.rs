//! The motorlab command.
fn main() {}
