//! How far the gap shrinks: nominal, refitted, refitted with effects, floor.
//!
//! Position error in counts RMS over pieces. Predicted rungs come from fits on the other folds, or from all named
//! runs where others are held out; their intervals from the Bayesian bootstrap (Rubin, 1981) over pieces, over runs where there are
//! enough.

use rand::SeedableRng;
use rand_distr::{Distribution, Exp1};
use rand_pcg::Pcg64Mcg;

use super::floor::{Floor, median, travel};
use crate::diagnose::fit::{Base, Fit, Left, Model, Unweighted, as_weighed, unweighted};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::report::{Fitted, Gap, PredictedRun, Verdict};
use crate::diagnose::settings::{CLOSES, CLUSTERED_RUNS, FOLDS, ROUNDING};
use crate::motor::Motor;

/// Draws of the bootstrap.
const DRAWS: u64 = 1000;

/// Squares of one piece, or run, under the three models, in counts^2, and its samples.
#[derive(Debug, Clone, Copy, Default)]
struct Block {
    squares: [f64; 3],
    samples: f64,
}

/// The three models, fitted to what is shown.
#[derive(Debug)]
pub(crate) struct Shown {
    nominal: Left,
    pub refitted: Unweighted,
    /// With effects; the refitted model where there are none, or where they leave more.
    pub with_effects: Unweighted,
    /// Whether the effects leave more than the refitted model, but for what does not matter, of what they are fitted to.
    leave_more: bool,
}

impl Shown {
    /// Fits them. The nominal model is among the starts of the refit, and the refit among those of the model with effects.
    ///
    /// With every sample weighed alike a load that wanders is fitted too, and predicts nothing. So of fits that weigh so and of those of
    /// the search those are shown and handed over that predict pieces better which they have not seen; but no model leaves
    /// more than one with less in it.
    pub fn new(pieces: &Pieces, base: &Base, refitted: &Fit, best: &Fit) -> Option<Self> {
        let plain = Model::new(base, Vec::new());
        let nominal = Left::new(pieces, &plain, base.kind, &plain.start())?;
        let starts = [plain.start(), refitted.x.clone()];
        let mut refit = unweighted(pieces, &plain, base.kind, &starts)?;
        let mut with_effects = refit.clone();
        let mut leave_more = false;
        if !best.model.members.is_empty() {
            let found = unweighted(
                pieces,
                &best.model,
                base.kind,
                std::slice::from_ref(&best.x),
            );
            match found {
                Some(found) if found.sum() <= refit.sum() => with_effects = found,
                Some(found) => leave_more = found.sum() > (1.0 + CLOSES) * refit.sum(),
                None => leave_more = true,
            }
        }
        let weighed = [refitted, best].map(|fit| as_weighed(pieces, base.kind, fit));
        if let [Some(again), Some(with)] = weighed
            && again.sum() <= nominal.sum()
            && with.sum() <= again.sum()
            && !leave_more
            && with.predicted_sum() < with_effects.predicted_sum()
        {
            (refit, with_effects) = (again, with);
        }
        Some(Self {
            nominal,
            refitted: refit,
            with_effects,
            leave_more,
        })
    }

    /// The motor that a verdict says: the nominal one where nothing is missing, other numbers where those are the cause. Where nothing known
    /// is, other numbers are taken if they predict what was kept from the fit better.
    pub fn motor_said(&self, verdict: Verdict, kept_back: &Gap) -> &Motor {
        let left = match verdict {
            Verdict::NoGap | Verdict::NoChange => &self.nominal,
            Verdict::Parameters => &self.refitted.left,
            Verdict::OutsideCatalogue if kept_back.after_parameters < kept_back.before => {
                &self.refitted.left
            }
            Verdict::OutsideCatalogue => &self.nominal,
            _ => &self.with_effects.left,
        };
        &left.motor
    }
}

/// Rungs with their bootstrap.
#[derive(Debug)]
pub(crate) struct Rungs {
    pub gap: Gap,
    /// The same sample by sample.
    pub predicted: Vec<PredictedRun>,
    draws: Vec<[f64; 3]>,
    /// The floor in counts RMS, drawn as often.
    floors: Vec<f64>,
    leave_more: bool,
}

impl Rungs {
    /// Probability that a rung (0 nominal, 1 refitted, 2 with effects) is not above the floor, which the repeats tell no better than
    /// their pieces agree.
    pub fn below_floor(&self, rung: usize) -> f64 {
        let both = self.draws.iter().zip(&self.floors);
        let below = both.filter(|(draw, floor)| draw[rung] <= **floor);
        below.count() as f64 / self.draws.len() as f64
    }

    /// Probability that the effects leave no more than the refitted model does, but for what does not matter, on pieces that were not
    /// fitted; 0 where they leave more of what they are fitted to.
    pub fn borne_out(&self) -> f64 {
        if self.leave_more {
            return 0.0;
        }
        let above = |left: f64| (left.powi(2) - ROUNDING).max(ROUNDING);
        let no_more = |draw: &&[f64; 3]| above(draw[2]) <= (1.0 + CLOSES) * above(draw[1]);
        self.draws.iter().filter(no_more).count() as f64 / self.draws.len() as f64
    }
}

impl Gap {
    /// What the model of a verdict leaves beyond rounding, in counts RMS: nothing random leaves more than that.
    pub(crate) fn beyond_rounding(&self, verdict: Verdict) -> f64 {
        let left = match verdict {
            Verdict::NoGap => self.fitted.before,
            Verdict::Parameters => self.fitted.after_parameters,
            _ => self.fitted.after_effect,
        };
        (left.powi(2) - self.floor_parts.rounding.powi(2))
            .max(0.0)
            .sqrt()
    }
}

/// The rungs of models on the pieces that they were fitted to, or on others: those that are held out, or all where some were searched.
pub(crate) fn rungs(
    (all, pieces): (&Pieces, &Pieces),
    held: Option<&Pieces>,
    shown: &Shown,
    floor: &Floor,
) -> Option<Rungs> {
    let models = [
        &shown.nominal,
        &shown.refitted.left,
        &shown.with_effects.left,
    ];
    let (measured, by_model) = match held {
        Some(held) => {
            let of = |left: &Left| Left::of(held, &left.motor, left.time_constant_s);
            (held, [of(models[0])?, of(models[1])?, of(models[2])?])
        }
        None => {
            let predicted = [&shown.refitted, &shown.with_effects].map(|fit| fit.predicted.clone());
            let [refitted, with_effects] = predicted;
            (
                pieces,
                [shown.nominal.shown.clone(), refitted, with_effects],
            )
        }
    };
    let blocks = blocks(measured, &by_model);
    let floors = {
        let mut random = Pcg64Mcg::seed_from_u64(0x666c_6f6f);
        (0..DRAWS).map(|_| floor.drawn(&mut random)).collect()
    };
    let floor_parts = floor.parts;
    let floor = floor_parts.largest();
    let rungs = rms(&blocks, &vec![1.0; blocks.len()]);
    let draws = bootstrap(&blocks);
    let closed: Vec<f64> = draws.iter().map(|draw| closed(*draw, floor)).collect();
    // A gap that is no larger beyond the floor than its own error has no share to be closed.
    let stands_out = quantiles(draws.iter().map(|draw| draw[0]).collect()).0 > floor;
    let (closed_lo95, closed_hi95) = if stands_out {
        quantiles(closed)
    } else {
        (0.0, 0.0)
    };
    let fitted = models.map(|left| {
        let squares: f64 = left.shown.iter().map(|r| r * r).sum();
        (squares / left.shown.len().max(1) as f64).sqrt()
    });
    let horizon = measured.pieces.iter().map(|piece| {
        let t_s = &measured.runs[piece.run].t_s;
        t_s[piece.to - 1] - t_s[piece.from]
    });
    let gap = Gap {
        metric: "position error in counts RMS over pieces, each from its own measured start",
        horizon_s: median(horizon.collect()),
        floor,
        floor_parts,
        wander: 0.0,
        travel: travel(measured),
        before: rungs[0],
        after_parameters: rungs[1],
        after_effect: rungs[2],
        closed: if stands_out {
            self::closed(rungs, floor)
        } else {
            0.0
        },
        closed_lo95,
        closed_hi95,
        fitted: Fitted {
            before: fitted[0],
            after_parameters: fitted[1],
            after_effect: fitted[2],
        },
        held_out: held_out_words((all, pieces), held),
        rungs95: [0, 1, 2].map(|k| quantiles(draws.iter().map(|draw| draw[k]).collect())),
    };
    Some(Rungs {
        gap,
        predicted: predicted(measured, &by_model),
        draws,
        floors,
        leave_more: shown.leave_more,
    })
}

/// What the models leave of each run, sample by sample.
fn predicted(measured: &Pieces, by_model: &[Vec<f64>; 3]) -> Vec<PredictedRun> {
    let mut runs: Vec<PredictedRun> = (measured.runs.iter().enumerate())
        .map(|(run, recording)| PredictedRun {
            run,
            gap_counts: [(); 3].map(|()| vec![f64::NAN; recording.t_s.len()]),
            starts: Vec::new(),
        })
        .collect();
    for piece in &measured.pieces {
        let run = &mut runs[piece.run];
        run.starts.push(piece.from);
        for (gap, left) in run.gap_counts.iter_mut().zip(by_model) {
            gap[piece.from..piece.to].copy_from_slice(&left[measured.range(piece)]);
        }
    }
    runs
}

/// How the data was kept from the fits.
fn held_out_words((all, pieces): (&Pieces, &Pieces), held: Option<&Pieces>) -> String {
    match held {
        Some(held) if std::ptr::eq(held, all) => format!(
            "{} pieces, predicted by a fit on {} of them",
            all.pieces.len(),
            pieces.pieces.len()
        ),
        Some(held) if held.runs.len() == 1 => "one run, kept from every fit and choice".to_owned(),
        Some(held) => format!("{} runs, kept from every fit and choice", held.runs.len()),
        None if pieces.stretches.len() > pieces.pieces.len() => format!(
            "samples of {} in {FOLDS} folds by turns, each predicted by a fit on the other folds; the effects are chosen on all",
            match pieces.pieces.len() {
                1 => "one piece".to_owned(),
                n => format!("{n} pieces"),
            },
        ),
        None => format!(
            "{} pieces in {} folds, each predicted by a fit on the other folds; the effects are chosen on all",
            pieces.pieces.len(),
            FOLDS
        ),
    }
}

/// Squares by piece; by run where there are runs enough, since pieces of a run are not independent.
fn blocks(pieces: &Pieces, by_model: &[Vec<f64>; 3]) -> Vec<Block> {
    let by_run = pieces.runs.len() >= CLUSTERED_RUNS;
    let count = if by_run {
        pieces.runs.len()
    } else {
        pieces.pieces.len()
    };
    let mut blocks = vec![Block::default(); count];
    for (k, piece) in pieces.pieces.iter().enumerate() {
        let block = &mut blocks[if by_run { piece.run } else { k }];
        block.samples += (piece.to - piece.from) as f64;
        for (sum, left) in block.squares.iter_mut().zip(by_model) {
            let of_piece = &left[pieces.range(piece)];
            *sum += of_piece.iter().map(|r| r * r).sum::<f64>();
        }
    }
    blocks
}

fn rms(blocks: &[Block], weights: &[f64]) -> [f64; 3] {
    let samples: f64 = blocks.iter().zip(weights).map(|(b, w)| w * b.samples).sum();
    [0, 1, 2].map(|k| {
        let squares = blocks.iter().zip(weights).map(|(b, w)| w * b.squares[k]);
        (squares.sum::<f64>() / samples.max(f64::MIN_POSITIVE)).sqrt()
    })
}

fn bootstrap(blocks: &[Block]) -> Vec<[f64; 3]> {
    let mut random = Pcg64Mcg::seed_from_u64(0x7275_6e67);
    let draw = |_| {
        let weights: Vec<f64> = blocks.iter().map(|_| Exp1.sample(&mut random)).collect();
        rms(blocks, &weights)
    };
    (0..DRAWS).map(draw).collect()
}

/// Share of what lies above the floor that is closed; what falls below the floor is at it.
fn closed([before, _, after]: [f64; 3], floor: f64) -> f64 {
    let above = before - floor;
    if above <= 0.0 {
        return 0.0;
    }
    1.0 - (after - floor).max(0.0) / above
}

/// The middle 95 %.
fn quantiles(mut values: Vec<f64>) -> (f64, f64) {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values[(share * (values.len() - 1) as f64).round() as usize];
    (at(0.025), at(0.975))
}

#[cfg(test)]
mod tests {
    use rand_distr::StandardNormal;

    use super::*;
    use crate::diagnose::noise::Passing;
    use crate::diagnose::report::FloorParts;
    use crate::diagnose::samples::{base_of, fitted, member, motor_with, recording};
    use crate::recording::Run;

    /// Correlation time in s of a load.
    const WANDER_TIME_S: f64 = 0.2;

    fn block(squares: [f64; 3]) -> Block {
        Block {
            squares,
            samples: 100.0,
        }
    }

    /// Where nothing is missing the motor stays as it is, and where nothing known is it takes the numbers that predict better.
    #[test]
    fn the_motor_is_the_one_that_a_verdict_says() {
        let truth = motor_with(&[("viscous_friction", &[0.02])]);
        let pieces = Pieces::new(&[recording(&truth, 1000)], &Motor::default()).expect("a run");
        let base = base_of(&pieces);
        let fit = fitted(&pieces, &base, &[]);
        let shown = Shown::new(&pieces, &base, &fit, &fit).expect("a motor");
        let floor = Floor::from(FloorParts {
            rounding: 0.3,
            repeats: None,
            good_enough: None,
        });
        let mut gap = rungs((&pieces, &pieces), None, &shown, &floor)
            .expect("rungs")
            .gap;
        let [nominal, refitted] = [&shown.nominal.motor, &shown.refitted.left.motor];
        assert!(nominal != refitted && gap.after_parameters < gap.before);
        assert_eq!(shown.motor_said(Verdict::NoGap, &gap), nominal);
        assert_eq!(shown.motor_said(Verdict::Parameters, &gap), refitted);
        assert_eq!(shown.motor_said(Verdict::OutsideCatalogue, &gap), refitted);
        gap.after_parameters = 2.0 * gap.before;
        assert_eq!(shown.motor_said(Verdict::OutsideCatalogue, &gap), nominal);
    }

    /// A motor whose load wanders by half a percent of the stall torque.
    fn wandering(truth: &Motor, seed: u64) -> Run {
        let mut run = recording(truth, 3000);
        let p = &truth.parameters;
        let stall_nm = p.torque_constant_nm_per_a * p.supply_v / p.resistance_ohm;
        let damping = p.torque_constant_nm_per_a * p.back_emf_v_s_per_rad / p.resistance_ohm;
        let counts = p.counts_per_rev / std::f64::consts::TAU;
        let sigma = 0.005 * stall_nm / p.inertia_kg_m2 * counts;
        let mut passing = Passing::new(p.inertia_kg_m2 / damping, WANDER_TIME_S);
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let (mut x, mut v, mut d) = (0.0, 0.0, 0.0);
        for k in 1..run.counts.len() {
            let step = passing.step(run.t_s[k] - run.t_s[k - 1], true);
            let drawn: f64 = StandardNormal.sample(&mut random);
            x += step.f01 * v + step.f02 * d;
            v = step.f11 * v + step.f12 * d;
            d = step.f22 * d + sigma * (1.0 - step.f22 * step.f22).sqrt() * drawn;
            run.counts[k] += x.floor() as i64;
        }
        run
    }

    /// Where every sample weighs alike a load that wanders is fitted too, and predicts nothing: of that fit and the search's own the one
    /// that predicts better is shown and handed over.
    #[test]
    fn under_a_wandering_load_the_motor_that_predicts_is_handed_over() {
        let truth = motor_with(&[("voltage_drop", &[0.8])]);
        let is_of_the_search = |seed: u64| {
            let pieces = Pieces::new(&[wandering(&truth, seed)], &Motor::default()).expect("a run");
            let base = base_of(&pieces);
            let refitted = fitted(&pieces, &base, &[]);
            let best = fitted(&pieces, &base, &[member("voltage_drop", 0.8)]);
            let start = std::slice::from_ref(&best.x);
            let evenly = unweighted(&pieces, &best.model, base.kind, start).expect("a motor");
            let own = as_weighed(&pieces, base.kind, &best).expect("a motor");
            let shown = Shown::new(&pieces, &base, &refitted, &best).expect("a motor");
            let of_each = [&shown.with_effects, &own, &evenly].map(Unweighted::predicted_sum);
            assert_eq!(
                of_each[0],
                of_each[1].min(of_each[2]),
                "{seed}: {of_each:?}"
            );
            shown.with_effects.left.motor == best.model.motor(&best.x)
        };
        let of_the_search = (1..7).filter(|seed| is_of_the_search(*seed)).count();
        assert!((1..6).contains(&of_the_search), "{of_the_search} of 6");
    }

    /// The share that is closed, by hand, and its interval about it; of equal pieces there is none.
    #[test]
    fn what_is_closed_is_that_above_the_floor() {
        assert!((closed([10.0, 5.0, 1.0], 0.5) - (1.0 - 0.5 / 9.5)).abs() < 1e-12);
        assert_eq!(closed([10.0, 5.0, 0.2], 0.5), 1.0);
        assert_eq!(closed([0.4, 0.4, 0.3], 0.5), 0.0);
        let equal = vec![block([400.0, 100.0, 25.0]); 6];
        for draw in bootstrap(&equal) {
            assert!(
                draw.iter()
                    .zip([2.0, 1.0, 0.5])
                    .all(|(a, b)| (a - b).abs() < 1e-12)
            );
        }
        let apart = [block([900.0; 3]), block([100.0; 3]), block([400.0; 3])];
        let (lo, hi) = quantiles(bootstrap(&apart).iter().map(|draw| draw[0]).collect());
        let rms = rms(&apart, &[1.0; 3])[0];
        assert!(
            1.0 < lo && lo < rms && rms < hi && hi < 3.0,
            "{lo} {rms} {hi}"
        );
    }
}
