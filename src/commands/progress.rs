//! Progress on stderr: a bar on a terminal, otherwise one line per stage or group.

use super::say;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rest3d_gpu::optimize::Event;
use rest3d_gpu::world::Energy;
use std::time::{Duration, Instant};

/// One line: the bar and what is done.
pub const SHORT: &str = "[{bar:20}] {wide_msg}";
/// Two lines, so that 80 columns suffice.
const LONG: &str = "[{bar:20}] {prefix}\n{wide_msg}";

/// A bar over `total` of something; hidden where stderr is no terminal.
pub fn bar(total: u64, template: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.progress_chars("=> "));
    }
    bar
}

/// The search's progress. Time left is estimated from the candidates that are still to be simulated.
pub struct SearchProgress {
    bar: ProgressBar,
    groups: Vec<Group>,
    started: Instant,
    /// Candidates simulated by this run: those of resumed groups and of stages that stopped early do not count.
    simulated: u64,
    last: Option<Line>,
}

struct Group {
    name: String,
    candidates: u64,
}

struct Line {
    group: usize,
    iteration: u32,
    best: Energy,
}

impl SearchProgress {
    /// Nothing to show before the plan is known.
    pub fn new() -> Self {
        Self { bar: ProgressBar::hidden(), groups: Vec::new(), started: Instant::now(), simulated: 0, last: None }
    }

    /// Shows one event.
    pub fn show(&mut self, event: &Event<'_>) {
        match event {
            Event::Seating => self.stage("setting objects onto their supports"),
            Event::Placing => self.stage("placing what is on walls and ceiling"),
            Event::Plan { groups, candidates, memory } => {
                self.groups = (groups.iter().zip(*candidates))
                    .map(|(name, &candidates)| Group { name: name.clone(), candidates })
                    .collect();
                self.bar = bar(candidates.iter().sum(), LONG);
                self.started = Instant::now();
                self.line(&format!("search: {} groups, {memory}", groups.len()));
            }
            Event::Iteration { group, iterations, stats } => {
                let before: u64 = self.groups[..*group].iter().map(|g| g.candidates).sum();
                let batch = self.groups[*group].candidates / u64::from(*iterations);
                let done = before + batch * u64::from(stats.iteration + 1);
                self.simulated += batch;
                self.bar.set_position(done);
                let left = self.bar.length().unwrap_or(done).saturating_sub(done);
                let left = time_left(self.started.elapsed(), self.simulated, left);
                let name = self.name(*group);
                self.bar.set_prefix(format!("{name}, iteration {}/{iterations}, {left} left", stats.iteration + 1));
                self.bar.set_message(terms(&stats.best));
                self.last = Some(Line { group: *group, iteration: stats.iteration + 1, best: stats.best });
            }
            Event::GroupDone { .. } => {
                if let Some(line) = self.last.take() {
                    let text =
                        format!("{}: {} iterations, {}", self.name(line.group), line.iteration, terms(&line.best));
                    self.line(&text);
                }
            }
            Event::Settling => self.stage("settling to rest"),
            Event::SettingAnew { objects } => {
                self.stage(&format!("setting down anew what rolls or has fallen over: {objects}"));
            }
            Event::Reconsidering { failing, round: [round, most], .. } => {
                self.stage(&format!(
                    "searching once more, round {round} of {most} at most: {failing} would move with other convex parts, lean or \
                     are off their supports"
                ));
            }
            Event::Parting => self.stage("parting the meshes"),
            Event::Verifying => self.stage("checking the result"),
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    fn stage(&self, name: &str) {
        self.bar.set_prefix(name.to_owned());
        self.bar.set_message("");
        self.line(name);
    }

    /// A line that stays, above the bar if there is one.
    pub fn line(&self, text: &str) {
        self.bar.suspend(|| say(format_args!("{text}")));
    }

    /// `local 2/7 desk`.
    fn name(&self, group: usize) -> String {
        let stage = if group + 1 == self.groups.len() { "" } else { "local " };
        format!("{stage}{} {}/{}", self.groups[group].name, group + 1, self.groups.len())
    }
}

fn terms(energy: &Energy) -> String {
    if !energy.total.is_finite() {
        return "no usable candidate yet".into();
    }
    format!(
        "energy {:.3}: stability {:.3}, velocity {:.3}, penetration {:.3}, layout {:.3}",
        energy.total, energy.stability, energy.velocity, energy.penetration, energy.layout
    )
}

/// `1:05`, at the pace of what was done so far.
pub fn time_left(elapsed: Duration, done: u64, left: u64) -> String {
    let seconds = (elapsed.as_secs_f64() * left as f64 / done.max(1) as f64).round() as u64;
    format!("{}:{:02}", seconds / 60, seconds % 60)
}
