//! A run from a virtual board in one call, for subcommands with their own recordings.

use std::path::Path;
use std::time::Duration;

use super::capture::capture_failure;
use super::output_file::mark;
use super::signals::StopSignal;
use super::virtual_spec::VirtualSpec;
use super::{Failure, Output};
use crate::board::{Board, BoardOptions, Profile};
use crate::recording::{CaptureRequest, Captured, Ending, SharedLive, capture};

/// Settings of the recording, besides the board.
#[derive(Debug, Clone, Copy)]
pub(super) struct Order<'a> {
    /// The recording subcommand: the run's header names it, and it may replace the run.
    pub command: &'static str,
    /// Text after `virtual:`.
    pub board: &'a str,
    /// Sample time in us.
    pub sample_time_us: u32,
    /// Name of a built-in profile, or a file.
    pub profile: &'a str,
    /// How long in s.
    pub duration_s: f64,
    /// Path of the run; the next free name is taken.
    pub output: &'a Path,
}

/// Records from a virtual board in this process, as `capture virtual:` does. `None` after Ctrl-C.
pub(super) async fn record(
    order: Order<'_>,
    stop: StopSignal,
    output: &Output,
) -> Result<Option<Captured>, Failure> {
    let spec = VirtualSpec::parse(order.board)
        .map_err(Failure::input)?
        .with_reported_gaps(output);
    let supply_v = spec.motor.parameters.supply_v;
    let profile =
        Profile::named(order.profile, supply_v, order.duration_s).map_err(Failure::input)?;
    let port = format!("virtual:{}", order.board);
    let plugged = spec.plug_in(&port).map_err(Failure::device)?;
    let options = BoardOptions {
        baud: firmware_protocol::BAUD,
        patience: Duration::from_secs(6),
        log: None,
    };
    let board = Board::open(plugged.location(), options).await;
    let mut board = board.map_err(Failure::device)?;
    let samples = (order.duration_s * 1e6 / f64::from(order.sample_time_us)).round();
    let request = CaptureRequest {
        sample_time_us: order.sample_time_us,
        profile,
        samples: samples.min(f64::from(u32::MAX)) as u32,
        counts_per_rev: None,
        supply_v: None,
        output: order.output.to_owned(),
        port,
        usb: None,
        further: toml::Table::from_iter([("written_by".to_owned(), mark(order.command).into())]),
    };
    let live = SharedLive::default();
    let captured = capture(&mut board, &request, &live, stop.asked()).await;
    let captured = captured.map_err(capture_failure)?;
    Ok((captured.ending != Ending::Stopped).then_some(captured))
}
