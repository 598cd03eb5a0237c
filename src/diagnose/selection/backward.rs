//! Backward elimination: whether members of a set can go (Draper and Smith, Applied Regression Analysis, 1998, chapter 15).
//!
//! Forward selection never takes back what it took first: what stood for the cause until the cause itself was found stays beside it.

use rayon::prelude::*;

use super::judged::{Judged, closed};
use crate::diagnose::fit::{Base, Fit, Member, Model, Most, fit};
use crate::diagnose::pieces::Pieces;
use crate::diagnose::settings::{CLOSES, LEAST_GAIN};

/// The last level judged anew without the members that can go, and how many of the levels before it still stand. None where every
/// member is needed.
pub(super) fn backward(
    pieces: &Pieces,
    base: &Base,
    levels: &[&Judged],
    best: &Fit,
    still: f64,
) -> Option<(usize, Judged)> {
    let mut left = best.clone();
    while let Some(smaller) = without_one(pieces, base, &left, best, still) {
        left = smaller;
    }
    let has =
        |fit: &Fit, member: &Member| fit.model.members.iter().any(|m| m.index == member.index);
    let gone: Vec<&Member> = (best.model.members.iter())
        .filter(|member| !has(&left, member))
        .collect();
    let is_within = |small: &Fit, large: &Fit| small.model.members.iter().all(|m| has(large, m));
    let standing = levels
        .iter()
        .take_while(|level| is_within(&level.from, &left));
    let stand = standing
        .count()
        .checked_sub(1)
        .filter(|_| !gone.is_empty())?;
    let from = &levels[stand].from;
    // Rivals of the same or a smaller size are those that were fitted on the way, and those of the last member beside what is left.
    let (last, before) = levels.split_last()?;
    let beside = last.tied().filter_map(|(rival, _)| {
        let mut members = rival.model.members.clone();
        members.retain(|member| !gone.iter().any(|other| other.index == member.index));
        let is_new = members.len() == left.model.members.len();
        is_new.then(|| refit(pieces, base, members, rival))?
    });
    let on_the_way = (before[stand..].iter().chain([last])).flat_map(|level| &level.fits);
    let is_rival =
        |fit: &&Fit| fit.model.members.len() <= left.model.members.len() && is_within(from, fit);
    let mut fits: Vec<Fit> = vec![left.clone()];
    for rival in beside.chain(on_the_way.filter(is_rival).cloned()) {
        if !fits
            .iter()
            .any(|other| other.model.ids() == rival.model.ids())
        {
            fits.push(rival);
        }
    }
    // Something is there as surely as the surest of these levels has it.
    let presences = levels[stand..].iter().map(|level| &level.presence);
    let presence = presences.max_by(|a, b| a.beyond_chance().total_cmp(&b.beyond_chance()))?;
    let mut judged = Judged::new(from, fits, presence.clone(), still);
    let stays = judged.fits.first()?.model.ids();
    let members = best.model.ids().into_iter();
    judged.gone = members.filter(|id| !stays.contains(id)).collect();
    judged.is_kept.then_some((stand, judged))
}

/// The likeliest set with one member less that predicts as well as `best` and leaves no more.
fn without_one(pieces: &Pieces, base: &Base, set: &Fit, best: &Fit, still: f64) -> Option<Fit> {
    let members = &set.model.members;
    if members.len() < 2 {
        return None;
    }
    let smaller = (0..members.len()).into_par_iter().filter_map(|gone| {
        let mut members = members.clone();
        members.remove(gone);
        refit(pieces, base, members, set)
    });
    let can_go =
        |fit: &Fit| fit.score() + LEAST_GAIN >= best.score() && closed(fit, best, still) < CLOSES;
    let smaller = smaller.filter(can_go);
    smaller.max_by(|a, b| a.score().total_cmp(&b.score()))
}

/// These members alone, from the numbers of a larger set and from their own.
fn refit(pieces: &Pieces, base: &Base, members: Vec<Member>, from: &Fit) -> Option<Fit> {
    let model = Model::new(base, members);
    let starts = [model.start_from(&from.model, &from.x), model.start()];
    let most = Most::beside(from.mean_square());
    fit(pieces, &model, base.kind, &starts, most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::samples::{base_of, fitted, member, motor_with, present, recording};
    use crate::diagnose::settings::ROUNDING;
    use crate::motor::Motor;

    /// What was taken first goes once the cause itself is there.
    #[test]
    fn what_stood_for_the_cause_goes() {
        let run = recording(&motor_with(&[("dead_zone", &[1.3])]), 1000);
        let pieces = Pieces::new(&[run], &Motor::default()).expect("a run");
        let base = base_of(&pieces);
        let (stand_in, cause) = (member("voltage_drop", 0.5), member("dead_zone", 1.3));
        let refitted = fitted(&pieces, &base, &[]);
        let first = fitted(&pieces, &base, std::slice::from_ref(&stand_in));
        let both = fitted(&pieces, &base, &[stand_in, cause]);
        let level =
            |from: &Fit, fit: &Fit| Judged::new(from, vec![fit.clone()], present(), ROUNDING);
        let levels = [level(&refitted, &first), level(&first, &both)];
        assert!(levels.iter().all(|level| level.is_kept));
        let levels: Vec<&Judged> = levels.iter().collect();
        let (stand, judged) =
            backward(&pieces, &base, &levels, &both, ROUNDING).expect("one that can go");
        assert_eq!(stand, 0);
        assert_eq!(judged.gone, ["voltage_drop"]);
        assert_eq!(judged.fits[0].model.ids(), ["dead_zone"]);
        // One that is alone has nothing that can go.
        assert!(backward(&pieces, &base, &levels[..1], &first, ROUNDING).is_none());
    }
}
