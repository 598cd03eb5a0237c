//! Screen of `capture --live`: the speed, recorded and simulated, and the figures.

use std::collections::VecDeque;

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style};
use ratatui::symbols::Marker;
use ratatui::text::Line;
use ratatui::widgets::{Axis, Block, Chart, Dataset, GraphType, Paragraph};

use crate::board::Bench;
use crate::motor::{Motor, Plant};
use crate::plain::shown;
use crate::recording::{CommandKind, Live, LivePoint, velocity_rad_s};
use crate::units::rpm_from_rad_s;

/// Most points kept for the plot.
const KEPT: usize = 4096;

/// Properties of the run besides its samples.
#[derive(Debug, Clone)]
pub(in crate::cli) struct LiveRun {
    /// The simulated motor.
    pub motor: Motor,
    /// Counts per revolution.
    pub counts_per_rev: f64,
    /// The port.
    pub port: String,
    /// The profile.
    pub profile: String,
}

/// Content of the screen.
pub(super) struct View {
    run: LiveRun,
    plant: Option<Plant>,
    recorded: VecDeque<LivePoint>,
    simulated: VecDeque<(f64, f64)>,
    followed: u64,
    first_counts: i64,
    last_command: f64,
    simulated_counts: i64,
    status: Status,
}

#[derive(Default)]
struct Status {
    path: String,
    sample_time_s: f64,
    samples: u64,
    lost: u64,
    overruns: u64,
}

impl View {
    pub(super) fn new(run: LiveRun) -> Self {
        // A motor that cannot be simulated is not drawn.
        let plant = Plant::new(&run.motor, CommandKind::Voltage, 0).ok();
        Self {
            run,
            plant,
            recorded: VecDeque::new(),
            simulated: VecDeque::new(),
            followed: 0,
            first_counts: 0,
            last_command: 0.0,
            simulated_counts: 0,
            status: Status::default(),
        }
    }

    /// Takes over the samples since the last call.
    pub(super) fn follow(&mut self, live: &Live) {
        self.status = Status {
            path: shown(&live.path),
            sample_time_s: live.sample_time_s,
            samples: live.samples,
            lost: live.lost,
            overruns: live.overruns,
        };
        let new = (live.samples - self.followed.min(live.samples)) as usize;
        let kept = live.recent.len();
        let from = kept - new.min(kept);
        self.followed = live.samples;
        for point in live.recent.range(from..) {
            if self.recorded.is_empty() {
                self.first_counts = point.counts;
            }
            self.simulate(point);
            self.recorded.push_back(*point);
        }
        self.recorded
            .drain(..self.recorded.len().saturating_sub(KEPT));
        self.simulated
            .drain(..self.simulated.len().saturating_sub(KEPT));
    }

    fn simulate(&mut self, point: &LivePoint) {
        let Some(plant) = &mut self.plant else {
            return;
        };
        plant.hold(self.last_command, point.t_s);
        self.last_command = point.command;
        let counts = Bench::counts(plant);
        let delta = counts as f64 - self.simulated_counts as f64;
        self.simulated_counts = counts;
        let (sample_time_s, counts_per_rev) = (self.status.sample_time_s, self.run.counts_per_rev);
        let before_s = self.recorded.back().map_or(0.0, |before| before.t_s);
        let elapsed = ((point.t_s - before_s) / sample_time_s).round().max(1.0) as u64;
        let speed = velocity_rad_s(delta, elapsed, counts_per_rev, sample_time_s);
        self.simulated.push_back((point.t_s, speed));
    }

    pub(super) fn draw(&self, frame: &mut Frame) {
        let [top, middle, bottom] = Layout::vertical([
            Constraint::Length(1),
            Constraint::Min(6),
            Constraint::Length(4),
        ])
        .areas(frame.area());
        let title = format!(
            " recording {} from {} every {} s, profile {}",
            self.status.path, self.run.port, self.status.sample_time_s, self.run.profile
        );
        frame.render_widget(Line::from(title), top);
        self.draw_speed(frame, middle);
        self.draw_figures(frame, bottom);
    }

    fn draw_speed(&self, frame: &mut Frame, area: Rect) {
        let columns = 2 * usize::from(area.width.saturating_sub(10)).max(1);
        let recorded: Vec<(f64, f64)> = self
            .recorded
            .iter()
            .map(|point| (point.t_s, point.speed_rad_s))
            .collect();
        let recorded = binned(&recorded, columns);
        let simulated: Vec<(f64, f64)> = self.simulated.iter().copied().collect();
        let simulated = binned(&simulated, columns);
        let (from, to) = match (recorded.first(), recorded.last()) {
            (Some(first), Some(last)) if last.0 > first.0 => (first.0, last.0),
            _ => (0.0, 1.0),
        };
        let all = || recorded.iter().chain(&simulated).map(|point| point.1);
        let low = all().fold(0.0, f64::min).floor();
        let high = all().fold(1.0, f64::max).ceil();
        let line = |name: &'static str, data, color| {
            Dataset::default()
                .name(name)
                .marker(Marker::Braille)
                .graph_type(GraphType::Line)
                .style(Style::new().fg(color))
                .data(data)
        };
        let chart = Chart::new(vec![
            line("simulated", &simulated, Color::Yellow),
            line("recorded", &recorded, Color::Cyan),
        ])
        .block(Block::bordered().title(" speed in RPM "))
        .x_axis(
            Axis::default()
                .bounds([from, to])
                .labels([format!("{from:.1} s"), format!("{to:.1} s")]),
        )
        .y_axis(
            Axis::default()
                .bounds([low, high])
                .labels([format!("{low:.0}"), format!("{high:.0}")]),
        );
        frame.render_widget(chart, area);
    }

    fn draw_figures(&self, frame: &mut Frame, area: Rect) {
        let Some(last) = self.recorded.back() else {
            frame.render_widget(Paragraph::new(" waiting for the first sample"), area);
            return;
        };
        let counts = last.counts.saturating_sub(self.first_counts);
        let mean = |speeds: &mut dyn Iterator<Item = f64>| {
            let (sum, count) = speeds.fold((0.0, 0), |(sum, n), speed| (sum + speed, n + 1));
            rpm_from_rad_s(sum / f64::from(count.max(1)))
        };
        let recorded = mean(&mut self.recorded.iter().rev().take(16).map(|p| p.speed_rad_s));
        let simulated = mean(&mut self.simulated.iter().rev().take(16).map(|p| p.1));
        let lost = Style::new().fg(if self.status.lost > 0 {
            Color::Red
        } else {
            Color::Green
        });
        let lines = vec![
            Line::from(format!(
                " {:9.2} s   {:6.2} V   {:9} samples",
                last.t_s, last.command, self.status.samples
            )),
            Line::styled(
                format!(
                    " {:9} lost   {:6} overruns",
                    self.status.lost, self.status.overruns
                ),
                lost,
            ),
            Line::from(format!(
                " counts {:9}   simulated {:9}   difference {:6}",
                counts,
                self.simulated_counts,
                counts.saturating_sub(self.simulated_counts)
            )),
            Line::from(format!(
                " RPM    {recorded:9.1}   simulated {simulated:9.1}   Ctrl-C stops and keeps the file"
            )),
        ];
        frame.render_widget(Paragraph::new(lines), area);
    }
}

/// Mean speeds over at most `columns` intervals, in RPM: one count is a large share of the speed of one sample.
fn binned(points: &[(f64, f64)], columns: usize) -> Vec<(f64, f64)> {
    let columns = columns.min(points.len());
    (0..columns)
        .map(|column| {
            let bin =
                &points[column * points.len() / columns..(column + 1) * points.len() / columns];
            let speed: f64 = bin.iter().map(|point| point.1).sum();
            (
                bin[bin.len() / 2].0,
                rpm_from_rad_s(speed / bin.len() as f64),
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    /// A view that follows a recording of the simulated motor in portions of these sizes.
    fn a_view(looks: &[usize]) -> View {
        let motor = Motor::default();
        let mut bench = Plant::new(&motor, CommandKind::Voltage, 0).expect("a motor");
        let mut view = View::new(LiveRun {
            motor,
            counts_per_rev: 720.0,
            port: "virtual:".to_owned(),
            profile: "step".to_owned(),
        });
        let (mut command, mut counts) = (0.0, 0);
        let mut live = Live {
            sample_time_s: 0.003,
            ..Live::default()
        };
        let mut k = 0_u32;
        for look in looks {
            for _ in 0..*look {
                let t_s = f64::from(k) * 0.003;
                bench.hold(command, t_s);
                command = if k < 100 { 0.0 } else { 4.5 };
                let before = std::mem::replace(&mut counts, Bench::counts(&mut bench));
                live.recent.push_back(LivePoint {
                    t_s,
                    speed_rad_s: velocity_rad_s((counts - before) as f64, 1, 720.0, 0.003),
                    command,
                    counts,
                });
                k += 1;
            }
            live.samples = u64::from(k);
            view.follow(&live);
        }
        view
    }

    #[test]
    fn the_simulated_counts_agree_with_the_recorded_ones() {
        for looks in [&[1000][..], &[1, 7, 300, 0, 692][..]] {
            let view = a_view(looks);
            assert_eq!(view.recorded.len(), 1000);
            let last = view.recorded.back().expect("a point");
            assert!(last.counts > 1000);
            assert_eq!(view.simulated_counts, last.counts);
            for (recorded, simulated) in view.recorded.iter().zip(&view.simulated) {
                assert_eq!(recorded.speed_rad_s, simulated.1);
            }
        }
    }

    #[test]
    fn the_view_fits_a_screen_of_80_by_24() {
        let view = a_view(&[1000]);
        let mut screen = Terminal::new(TestBackend::new(80, 24)).expect("memory");
        screen.draw(|frame| view.draw(frame)).expect("memory");
        let text = screen.backend().to_string();
        for word in [
            "speed in RPM",
            "simulated",
            "4.50 V",
            "1000 samples",
            "0 lost",
            "difference",
        ] {
            assert!(text.contains(word), "{word} in\n{text}");
        }
        assert!(
            text.chars()
                .filter(|c| ('\u{2801}'..='\u{28ff}').contains(c))
                .count()
                > 50
        );
        // Smaller screens have fewer lines; the recording is unaffected.
        for (columns, rows) in [(20, 5), (1, 1), (200, 60)] {
            let mut screen = Terminal::new(TestBackend::new(columns, rows)).expect("memory");
            screen.draw(|frame| view.draw(frame)).expect("memory");
        }
    }
}
