//! Answers of Part 3.

use super::{Answer, NO_USABLE_RECORDING, not_usable, usable};
use crate::diagnose::{Diagnosis, NominalSource, Settings, Verdict};
use crate::lab::Source;
use crate::lab::missing::Missing;
use crate::lab::not_shown::{self, NotShown};
use crate::lab::recorded::{MODELS, Recorded, WITH_EFFECTS};
use crate::lab::sampling::SAMPLE_TIMES_S;
use crate::recording::Run;
use crate::report::demo::two_measures;
use crate::report::number::{change, figure, percent, probability_of, rpm, time};

pub(super) fn plots(runs: &[Recorded], source: &Source) -> Answer {
    let mut because = vec![
        "Units: the recorder writes counts; both sides become rad/s by the same difference rule, (n[k] \u{2212} n[k\u{2212}1]) 2\u{3c0} / (N TS), and RPM by 60 / 2\u{3c0}.".to_owned(),
    ];
    for ts in SAMPLE_TIMES_S {
        if !runs
            .iter()
            .any(|recorded| (recorded.sample_time_s / ts - 1.0).abs() < 0.01)
        {
            because.push(format!(
                "No recording at TS\u{a0}=\u{a0}{ts}\u{a0}s was given; the handout asks for one."
            ));
        }
    }
    let recordings = match runs.len() {
        1 => "the recording".to_owned(),
        several => format!("the {several} recordings"),
    };
    let short = match source {
        Source::Recorded => format!("See the plots of {recordings}."),
        Source::VirtualBoard(_) => format!(
            "See the plots of {recordings}. No recording was given: a virtual board, which is itself a simulation, supplied them over the recorder's protocol."
        ),
    };
    Answer {
        number: "3.1",
        topic: "Plots of the recorded against the simulated discretised response at both sample times",
        short,
        because,
    }
}

pub(super) fn match_now(runs: &[Recorded]) -> Answer {
    let usable = usable(runs);
    let because = usable
        .iter()
        .flat_map(|recorded| {
            let file = recorded.name();
            recorded.models.iter().map(move |model| {
                let figures = &model.figures;
                format!(
                    "{file}, {}: position {} counts RMS (rounding alone leaves {}), speed {} RPM RMS{}.",
                    model.name,
                    figure(figures.position_rmse_counts, 3),
                    figure(figures.floor_counts, 3),
                    figure(figures.velocity_rmse_rpm, 3),
                    figures.velocity_nrmse.map_or_else(String::new, |relative| format!(
                        ", {} of how much the recorded speed varies",
                        percent(relative)
                    ))
                )
            })
        })
        .collect();
    let sentences: Vec<String> = usable
        .iter()
        .filter_map(|recorded| {
            let without = recorded.model(MODELS[0].name)?;
            let with = recorded.model(MODELS[3].name)?;
            Some(format!(
                "At TS\u{a0}=\u{a0}{}\u{a0}s the simulation with friction is off by {} counts and {} RPM RMS over the whole run, without friction by {} counts and {} RPM.",
                recorded.sample_time_s,
                figure(with.figures.position_rmse_counts, 3),
                figure(with.figures.velocity_rmse_rpm, 3),
                figure(without.figures.position_rmse_counts, 3),
                figure(without.figures.velocity_rmse_rpm, 3)
            ))
        })
        .collect();
    let short = match sentences.as_slice() {
        [] if !runs.is_empty() => NO_USABLE_RECORDING.to_owned(),
        said => said.join(" "),
    };
    Answer {
        number: "3.2",
        topic: "How well does the simulated response match now, with and without friction?",
        short: short + &not_usable(runs),
        because,
    }
}

/// Whether a recording has commands in both directions.
fn reverses(run: &Run) -> bool {
    let driven = |sign: f64| run.command.iter().any(|command| sign * command > 0.0);
    driven(1.0) && driven(-1.0)
}

pub(super) fn missing(
    runs: &[Recorded],
    missing: &Missing,
    not_shown: &[NotShown],
    source: &Source,
) -> Answer {
    let usable = usable(runs);
    let open: Vec<&Recorded> = (usable.iter().copied())
        .filter(|recorded| !recorded.is_at_the_floor())
        .collect();
    let mut because = Vec::new();
    for recorded in &open {
        let Some(best) = recorded.best() else {
            continue;
        };
        let figures = &best.figures;
        let unexplained = (figures.position_rmse_counts.powi(2) - figures.floor_counts.powi(2))
            .max(0.0)
            .sqrt();
        let mut text = format!(
            "{}: beyond the rounding, \u{201c}{}\u{201d} leaves {} counts RMS, up to {} counts.",
            recorded.name(),
            best.name,
            figure(unexplained, 3),
            figure(figures.position_largest_counts, 3)
        );
        if let (Some(steady), Some(speed)) = (recorded.steady, best.steady_rad_s) {
            text += &format!(
                " Its steady speed is {} against {} recorded ({}).",
                rpm(speed),
                rpm(steady.speed_rad_s),
                change(speed / steady.speed_rad_s - 1.0)
            );
        }
        because.push(text);
    }
    for recorded in &usable {
        if let (Some(plain), Some(with)) =
            (recorded.model(MODELS[3].name), recorded.model(WITH_EFFECTS))
        {
            because.push(format!(
                "{}: the motor file's effects bring the position error from {} to {} counts RMS.",
                recorded.name(),
                figure(plain.figures.position_rmse_counts, 3),
                figure(with.figures.position_rmse_counts, 3)
            ));
        }
    }
    if open.is_empty() && !usable.is_empty() && matches!(source, Source::VirtualBoard(_)) {
        because.push("The virtual board is a simulation too: without an effect of its own it turns the very model that it is compared with.".to_owned());
    }
    let seen = ExcessDeviation {
        differing: open.len(),
        recordings: usable.len(),
    };
    let short = match missing {
        Missing::Diagnosed(diagnosis) => {
            because.extend(diagnosed(diagnosis));
            // A fitted motor does not have the handout's parameters.
            let verdict = match (diagnosis.verdict, diagnosis.nominal_source) {
                (Verdict::NoGap, NominalSource::Fit) if !open.is_empty() => Verdict::Parameters,
                (verdict, _) => verdict,
            };
            let measures = match verdict {
                Verdict::NoGap => String::new(),
                _ => two_measures(diagnosis) + " ",
            };
            format!(
                "{} {measures}The diagnosis: {}{}",
                seen.answer(
                    verdict,
                    &diagnosis.effects,
                    diagnosis.probability,
                    &diagnosis.settings
                ),
                diagnosis.sentence,
                not_shown::words(not_shown, usable.iter().any(|one| reverses(&one.run)))
            )
        }
        Missing::Undiagnosed(why) => {
            because.push(format!("No diagnosis: {why}."));
            match usable.is_empty() {
                true => NO_USABLE_RECORDING.to_owned() + &not_usable(runs),
                false => seen.alone() + &not_usable(runs),
            }
        }
    };
    Answer {
        number: "3.a",
        topic: "What is missing in the simulation?",
        short,
        because,
    }
}

/// Recordings that differ from every model of the handout by more than quantization.
#[derive(Debug, Clone, Copy)]
struct ExcessDeviation {
    differing: usize,
    recordings: usize,
}

impl ExcessDeviation {
    /// Agreement of the recordings with the models of the handout.
    fn words(self) -> String {
        match self.differing {
            0 => "over the whole run a model of the handout meets every recording to about the encoder's rounding"
                .to_owned(),
            differing => format!(
                "{differing} of {} recordings differ from every model of the handout by more than the encoder's rounding",
                self.recordings
            ),
        }
    }

    /// Without a diagnosis.
    fn alone(self) -> String {
        format!(
            "Without a diagnosis this is all that is seen: {}.",
            self.words()
        )
    }

    /// Missing effect: exactly the verdict.
    fn answer(
        self,
        verdict: Verdict,
        effects: &[&str],
        probability: f64,
        settings: &Settings,
    ) -> String {
        let seen = self.words();
        let named = effects.join(" and ");
        let p = |event: &str| probability_of(event, probability);
        match verdict {
            Verdict::NoGap => format!(
                "Nothing that these recordings show, {}: {seen}, and the diagnosis finds no gap.",
                p("no effect is present")
            ),
            Verdict::Parameters => {
                let missing = match probability {
                    p if p < settings.identified => {
                        "An effect is probably missing that these recordings do not identify"
                    }
                    p if p < settings.confident => "Probably no effect is missing",
                    _ => "No effect is missing",
                };
                format!(
                    "{missing}, {}; the motor's parameters differ: {seen}.",
                    p("no effect is present")
                )
            }
            Verdict::Effect => format!("This is missing: {named}, {}; {seen}.", p("")),
            Verdict::Partial => format!(
                "This is missing: {named}, {}, and a part that no effect of the catalogue explains; {seen}.",
                p("")
            ),
            Verdict::Ambiguous => format!(
                "These recordings do not settle it: {seen}, and several effects remain, {}.",
                p("one of them is present")
            ),
            Verdict::OutsideCatalogue => format!(
                "Something that no effect of the catalogue explains: {seen}; {}.",
                p("no effect of the catalogue is present")
            ),
            Verdict::NoChange => format!(
                "Nothing beyond the reference, {}: {seen}.",
                p("no effect has changed")
            ),
            Verdict::BadRecording => {
                "That cannot be said: a finding about the recording is fatal.".to_owned()
            }
        }
    }
}

/// The figures of the diagnosis as sentences; the causes are in a separate table.
fn diagnosed(diagnosis: &Diagnosis) -> Vec<String> {
    let gap = &diagnosis.gap;
    let whose = match diagnosis.nominal_source {
        NominalSource::Given => "the motor file's",
        NominalSource::Handout => "the handout's",
        NominalSource::Fit => "fitted",
    };
    let mut sentences = vec![format!(
        "Held-out RMS error ({}): {} counts with {whose} parameters, {} with re-identified parameters, {} with the identified effects; noise floor {}.",
        gap.held_out,
        figure(gap.before, 3),
        figure(gap.after_parameters, 3),
        figure(gap.after_effect, 3),
        figure(gap.floor, 3)
    )];
    let is_unexplained = diagnosis.unexplained.share > 0.0;
    if let Some(region) = (diagnosis.place.regions.first()).filter(|_| is_unexplained) {
        sentences.push(format!(
            "Where: {} of the unexplained error is {}, from {} to {} of {}.",
            percent(region.share),
            region.regime.words(),
            time(region.from_s),
            time(region.to_s),
            file_name(&region.run)
        ));
    }
    for problem in &diagnosis.data {
        sentences.push(format!(
            "The recording {} itself: {}.",
            file_name(&problem.run),
            problem.message
        ));
    }
    sentences
}

fn file_name(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An answer begins with "Nothing" exactly where the diagnosis finds no gap; it names the effects of the verdict.
    #[test]
    fn the_answer_states_the_verdict() {
        let verdicts = [
            (Verdict::BadRecording, vec![]),
            (Verdict::NoGap, vec![]),
            (Verdict::Parameters, vec![]),
            (Verdict::Effect, vec!["dead_zone", "backlash"]),
            (Verdict::Partial, vec!["dead_zone"]),
            (Verdict::Ambiguous, vec![]),
            (Verdict::OutsideCatalogue, vec![]),
        ];
        for differing in [0, 2] {
            let seen = ExcessDeviation {
                differing,
                recordings: 2,
            };
            for (verdict, effects) in &verdicts {
                let said = seen.answer(*verdict, effects, 0.69, &Settings::default());
                let has_probability = said.contains("=\u{a0}0.69");
                assert_eq!(has_probability, *verdict != Verdict::BadRecording, "{said}");
                assert!(!said.starts_with("No effect"), "{said}");
                assert_eq!(
                    said.starts_with("Nothing"),
                    *verdict == Verdict::NoGap,
                    "{said}"
                );
                assert!(effects.iter().all(|id| said.contains(id)), "{said}");
                let is_open = matches!(verdict, Verdict::Ambiguous);
                assert_eq!(said.contains("do not settle"), is_open, "{said}");
                let more = matches!(verdict, Verdict::Partial | Verdict::OutsideCatalogue);
                let unexplained = said.contains("no effect of the catalogue explains");
                assert_eq!(unexplained, more, "{said}");
            }
        }
    }
}
