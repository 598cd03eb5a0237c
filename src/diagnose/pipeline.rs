//! From runs to fitted sets: the steps of a diagnosis that use the data.

use crate::motor::catalogue::ids;
use std::cell::Cell;

use super::error::{DiagnoseError, usable};
use super::fit::{Fit, Metric, fit};
use super::inverse::{own_part, shares};
use super::model::{Base, Model};
use super::nested::least_squares;
use super::relevance::{exceeds, noise_floor};
use super::score::{effective_observations, fitted_time_constant_s};
use super::search::{Found, search};
use super::segments::{Recording, Segments, Subset};
use super::settings::Settings;
use super::settings::conventions::{LEFT_AFTER_ROUND, MOVED_COUNTS, REFITTED_SHARE};
use super::settings::solver::CONVERGED;
use crate::motor::Motor;
use crate::motor::catalogue::find;
use crate::recording::Run;

/// Runs cut into segments, and the data shared by all models of them.
pub(crate) struct Prepared<'a> {
    /// Segments of the whole runs.
    pub all: Segments,
    /// The searched subset of long runs.
    pub subset: Option<Subset>,
    pub runs: &'a [Run],
    pub base: Base,
}

impl<'a> Prepared<'a> {
    /// For these runs; a quick answer searches a subset of short runs too.
    pub fn new(
        runs: &'a [Run],
        motor: &Motor,
        settings: &Settings,
        quick: bool,
    ) -> Result<Self, DiagnoseError> {
        let kind = usable(runs)?;
        let mut motor = motor.clone();
        motor.parameters.counts_per_rev = runs[0].counts_per_rev;
        motor.parameters.supply_v = runs[0].supply_v.unwrap_or(motor.parameters.supply_v);
        let all = Segments::new(runs, &motor, settings)?;
        let subset = match quick {
            true => Subset::quick(&all, runs, &motor)?,
            false => Subset::new(&all, runs, &motor, settings.searched_samples, None)?,
        };
        let clocks = all.runs.iter().filter_map(|run| run.clock);
        let longest = clocks.max_by(|a, b| a.1.total_cmp(&b.1));
        // A larger error than a clock's is no measurement: rows were sent faster than real time, or all at once.
        let longest = longest.filter(|(error, _)| error.abs() < plausible_clock_error(&motor));
        let base = Base {
            kind,
            sample_time_s: all.runs[0].sample_time_s,
            clock: longest.map(|(error, span_s)| (error, settings.clock_reading_s / span_s)),
            is_host_timed: runs.iter().any(Run::is_host_timed),
            torque_identifiable: runs.iter().any(|run| run.known.has_torque()),
            reference: None,
            dead_time_s: all.runs.iter().map(dead_time_s).fold(0.0, f64::max),
            settings: *settings,
            motor,
        };
        Ok(Self {
            all,
            subset,
            runs,
            base,
        })
    }

    /// Searched segments, and their runs.
    pub fn searched(&self) -> (&Segments, &[Run]) {
        match &self.subset {
            Some(subset) => (&subset.segments, &subset.runs),
            None => (&self.all, self.runs),
        }
    }
}

/// Largest plausible rate error of a clock in the catalogue.
fn plausible_clock_error(motor: &Motor) -> f64 {
    let parameter = find(ids::CLOCK_ERROR).and_then(|(_, kind)| kind.parameters.first());
    parameter.map_or(0.0, |parameter| parameter.range(&motor.parameters, 1.0).1)
}

/// Time in s from the first command of a run that begins at rest to its first motion.
fn dead_time_s(run: &Recording) -> f64 {
    let commanded = run.command.iter().position(|u| *u != 0.0);
    let moved = run.counts.iter().position(|n| n.abs() > MOVED_COUNTS);
    match (commanded, moved) {
        (Some(from), Some(to)) if to > from => run.t_s[to] - run.t_s[from],
        _ => 0.0,
    }
}

/// Result of the search.
pub(crate) struct Searched {
    /// The searched segments, initial states corrected for the re-identified motor.
    pub segments: Segments,
    /// All segments, corrected likewise.
    pub all: Segments,
    /// Maximum posterior fit without effects.
    pub none: Fit,
    /// Noise floor in counts RMS: residual for simulated recordings of the re-identified motor.
    pub quantization: f64,
    pub found: Found,
}

/// Fits, tests relevance, searches; the stated floor is repeatability or the accepted error, in counts RMS.
pub(crate) fn searched(
    prepared: &Prepared,
    stated_floor_counts: f64,
    proposed: &[Motor],
    progress: &dyn Fn(&str),
    done: &dyn Fn(f64),
) -> Result<Searched, DiagnoseError> {
    let Prepared { all, base, .. } = prepared;
    let settings = &base.settings;
    let (segments, runs) = prepared.searched();
    let model = Model::new(base, Vec::new());
    progress("re-identifying the parameters");
    let nominal = Fit::at(segments, &model, model.start()).ok_or(DiagnoseError::NoFit)?;
    let mut starts = vec![model.start()];
    starts.extend(own_part(segments).map(|own| model.start_with(shares(base, own))));
    let n_eff = effective_observations(segments, &nominal.corrected);
    let first = fit(
        segments,
        &model,
        &starts,
        Metric::ScaleFree(n_eff),
        CONVERGED,
        None,
    );
    let first = first.ok_or(DiagnoseError::NoFit)?;
    // Initial states are corrected once for the fitted motor.
    let tau_s = fitted_time_constant_s(&first);
    let segments = segments.clone().with_time_constant(tau_s);
    let all = all.clone().with_time_constant(tau_s);
    let n_eff = effective_observations(&segments, &first.corrected);
    let none = fit(
        &segments,
        &model,
        &[first.x],
        Metric::ScaleFree(n_eff),
        CONVERGED,
        None,
    );
    let none = none.ok_or(DiagnoseError::NoFit)?;
    starts.push(none.x.clone());
    let refitted = least_squares(&segments, &model, &starts).ok_or(DiagnoseError::NoFit)?;
    let floor = noise_floor(&segments, &refitted).ok_or(DiagnoseError::NoFit)?;
    let n_eff = effective_observations(&segments, &refitted.corrected);
    let stated_floor = stated_floor_counts.powi(2);
    let is_relevant = exceeds(
        refitted.mean_square(),
        floor.max(stated_floor),
        n_eff,
        settings,
    );
    // Segments of a slow motor, or of a fast board, are long.
    let segment = segments.len / segments.segments.len().max(1);
    let most = settings
        .screened_samples
        .max(settings.screened_segments * segment);
    let coarse = Subset::new(
        &segments,
        runs,
        &none.model.motor(&none.x),
        most,
        Some(&none.corrected),
    )?;
    let coarse = coarse.as_ref().map_or(&segments, |subset| &subset.segments);
    let begun = if is_relevant { &none } else { &refitted };
    // The number of rounds is unknown: each is reported as a part of the remaining share.
    let (from, to) = (Cell::new(0.0), Cell::new(REFITTED_SHARE));
    let progress = |what: &str, part: f64| {
        if part == 0.0 {
            from.set(to.get());
            to.set(1.0 - (1.0 - to.get()) * LEFT_AFTER_ROUND);
        }
        done(from.get() + part * (to.get() - from.get()));
        progress(what);
    };
    let found = search(
        &segments,
        coarse,
        base,
        begun,
        (is_relevant, stated_floor),
        proposed,
        &progress,
    );
    let found = found.ok_or(DiagnoseError::NoFit)?;
    Ok(Searched {
        quantization: floor.sqrt(),
        segments,
        all,
        none,
        found,
    })
}
