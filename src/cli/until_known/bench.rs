//! The bench that is recorded: a port, or a virtual board that changes itself as a recording requires.

use std::path::PathBuf;
use std::time::Duration;

use super::plan::Plan;
use crate::board::{Board, BoardOptions, Location, VirtualBoard};
use crate::cli::capture::{Capture, board_failure, capture_failure};
use crate::cli::signals::StopSignal;
use crate::cli::virtual_spec::{PREFIX, VirtualSpec, nearly};
use crate::cli::{Failure, Output};
use crate::diagnose::KnownChange;
use crate::motor::KnownDifferences;
use crate::recording::{Captured, SharedLive, capture};

/// A port, and its virtual board if it is one.
pub(super) struct Bench<'a> {
    asked: &'a Capture,
    plugged: Option<(VirtualBoard, Option<KnownChange>)>,
}

impl<'a> Bench<'a> {
    pub fn of(asked: &'a Capture) -> Self {
        Self {
            asked,
            plugged: None,
        }
    }

    /// Whether discs, loads and supplies are changed automatically.
    pub fn changes_itself(&self) -> bool {
        self.asked.port.starts_with(PREFIX)
    }

    /// Location of the board, with a change on the bench.
    fn location(
        &mut self,
        change: Option<&KnownChange>,
        output: &Output,
    ) -> Result<Location, Failure> {
        let Some(text) = self.asked.port.strip_prefix(PREFIX) else {
            let port = PathBuf::from(&self.asked.port);
            return nearly(&self.asked.port).map_or(Ok(Location::Port(port)), Err);
        };
        if let Some((board, made)) = &self.plugged
            && made.as_ref() == change
        {
            return Ok(board.location().clone());
        }
        let mut spec = VirtualSpec::parse(text)
            .map_err(Failure::input)?
            .with_reported_gaps(output);
        if let Some(KnownChange { key, value }) = change {
            let mut known = KnownDifferences::default();
            known.set(key, *value).map_err(Failure::input)?;
            spec.motor = known.applied_to(&spec.motor);
        }
        // A mounted arm hangs down at count 0, so that a changed bench restarts.
        let board = spec.plug_in(&self.asked.port).map_err(Failure::input)?;
        let location = board.location().clone();
        self.plugged = Some((board, change.cloned()));
        Ok(location)
    }

    /// Records a plan into `file`; `None` if Ctrl-C comes before the board has identified itself.
    pub async fn record(
        &mut self,
        plan: &Plan,
        file: PathBuf,
        stop: &StopSignal,
        output: &Output,
    ) -> Result<Option<Captured>, Failure> {
        let location = self.location(plan.change.as_ref(), output)?;
        let options = BoardOptions {
            baud: self.asked.baud,
            patience: Duration::from_secs_f64(self.asked.patience),
            log: None,
        };
        let mut board = tokio::select! {
            board = Board::open(&location, options) => board.map_err(board_failure)?,
            () = stop.clone().asked() => return Ok(None),
        };
        let mut one = self.asked.clone();
        one.profile = Some(plan.profile.clone());
        one.duration = Some(plan.duration_s);
        one.output = file;
        let mut request = one.request(&board, location.path())?;
        // The header states the changes of the bench for `diagnose`; the supply already is in it.
        if let Some(KnownChange { key, value }) = plan.change.as_ref()
            && key != "supply_v"
        {
            let differs = toml::Table::from_iter([(key.clone(), (*value).into())]);
            request.further.insert("differs".to_owned(), differs.into());
        }
        let live = SharedLive::default();
        let counts_per_rev = f64::from(board.hello().counts_per_rev);
        let display = one.display(&live, counts_per_rev, &request.profile.name, output)?;
        let captured = capture(&mut board, &request, &live, stop.clone().asked()).await;
        drop(display);
        captured.map(Some).map_err(capture_failure)
    }
}
