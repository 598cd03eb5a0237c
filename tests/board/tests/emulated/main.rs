//! The sketch on emulated boards, compared with the true events.

mod capture;
mod faults;
mod protocol;
mod rates;
mod recording;
mod sizes;
mod support;

#[path = "../../../support/command.rs"]
mod command;
