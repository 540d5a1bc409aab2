//! What rolls or has fallen over, set down anew: where it was set before the search, as it was reconstructed, leaning on
//! what is there. A pear that is let go comes to rest in few poses, and no random turn finds them.

use super::tolerances::{ANOTHER_PLACE, FAR_OFF, FINALISTS_OF_ONE, POSES};
use super::{Event, Layout, Observer, Opinions, cheaper, finalists, trial::Trial};
use crate::scene;
use crate::world::{BackendError, Flow};
use std::sync::atomic::Ordering;

impl Opinions<'_> {
    /// The layout with all that fails and rolls or has fallen over set down anew, one after the other; none if nothing
    /// does.
    pub(super) fn all_anew(&self, trial: &Trial) -> Result<Option<Layout>, BackendError> {
        let mut layout = trial.layout.clone();
        let objects = self.to_set_anew(trial);
        for &object in &objects {
            if self.flow() == Flow::Stop {
                break;
            }
            if let Some(anew) = self.set_down_among_others(object, &layout, 1)?.pop() {
                layout = anew;
            }
        }
        Ok((!objects.is_empty()).then_some(layout))
    }

    /// The best layout with all that fails and rolls or has fallen over set down anew, over and over at most so many times,
    /// until none of it finds a better place; and whether that is so.
    pub(super) fn each_anew(
        &self,
        mut best: Trial,
        times: usize,
        observer: &mut dyn Observer,
    ) -> Result<(Trial, bool), BackendError> {
        // What found no better place in the layout as it is now.
        let mut in_vain: Vec<usize> = Vec::new();
        let left = |best: &Trial, in_vain: &[usize]| {
            let left = |object: &usize| !in_vain.contains(object);
            self.to_set_anew(best).into_iter().filter(left).collect::<Vec<usize>>()
        };
        for _ in 0..times {
            let objects = left(&best, &in_vain);
            if objects.is_empty() || self.tells(objects.len(), observer) == Flow::Stop {
                break;
            }
            for object in objects {
                match self.anew(&best, object)? {
                    Some(better) => {
                        best = better;
                        in_vain.clear();
                    }
                    None => in_vain.push(object),
                }
            }
        }
        let nothing_left = left(&best, &in_vain).is_empty();
        Ok((best, nothing_left))
    }

    /// The same once with what rolls and has come to stand far from how it was set onto its support, the farthest first,
    /// if no more fails then: what was in its place may have gone.
    pub(super) fn far_anew(&self, mut best: Trial, observer: &mut dyn Observer) -> Result<Trial, BackendError> {
        let away = |&object: &usize| {
            let place = self.run.place(object, &best.layout);
            (object, self.between(object, &best.layout[object], &place))
        };
        let mut far: Vec<(usize, f64)> = self.run.rolling.iter().map(away).collect();
        far.retain(|(object, away)| !best.failing.contains(object) && *away > FAR_OFF);
        far.sort_by(|a, b| b.1.total_cmp(&a.1));
        if !far.is_empty() && self.tells(far.len(), observer) == Flow::Continue {
            for (object, _) in far {
                let nearer = self.anew(&best, object)?;
                best = nearer.filter(|nearer| nearer.failing.len() <= best.failing.len()).unwrap_or(best);
            }
        }
        Ok(best)
    }

    /// Tells the observer, who may end the run.
    fn tells(&self, objects: usize, observer: &mut dyn Observer) -> Flow {
        if observer.event(Event::SettingAnew { objects }) == Flow::Stop {
            self.stop.store(true, Ordering::Relaxed);
        }
        self.flow()
    }

    /// The layout with an object set down anew in the pose with which the whole costs least, if it costs less than before.
    fn anew(&self, best: &Trial, object: usize) -> Result<Option<Trial>, BackendError> {
        if self.flow() == Flow::Stop {
            return Ok(None);
        }
        let layouts = self.set_down_among_others(object, &best.layout, POSES)?;
        let focused = self.focused(best, &[&best.failing[..], &[object]].concat());
        let trials = focused.judge_copies(focused.settled(&focused.settling, &layouts)?, best)?;
        let finalists = finalists(trials, best, FINALISTS_OF_ONE);
        let trials = self.judge(self.settled(&self.settling, &finalists)?)?;
        Ok(cheaper(trials, best).filter(|_| self.flow() == Flow::Continue))
    }

    /// The layout with an object, and what is on it, set down in so many poses of rest near to how it was reconstructed at
    /// `most`, the best first, on its parent and leaning on what is there: near where it was set before the search, or near
    /// where it is if there is no rest for it.
    fn set_down_among_others(&self, object: usize, layout: &Layout, most: usize) -> Result<Vec<Layout>, BackendError> {
        let center = |pose: &scene::Pose| self.run.rigs[object].center_of(pose).with_y(0.0);
        let (here, place) = (layout[object], self.run.place(object, layout));
        let mut layouts = Vec::new();
        if center(&place).distance(center(&here)) > ANOTHER_PLACE {
            layouts = self.set_down_near(object, &place, layout)?;
        }
        if layouts.is_empty() {
            layouts = self.set_down_near(object, &here, layout)?;
        }
        layouts.truncate(most);
        Ok(layouts)
    }

    fn set_down_near(&self, object: usize, pose: &scene::Pose, layout: &Layout) -> Result<Vec<Layout>, BackendError> {
        let (seat, mut as_input) = (self.run.seat(&self.run.room), layout.clone());
        seat.carry(object, self.run.rigs[object].turned(pose, self.run.input[object].rotation), &mut as_input);
        // What lies is lower than it stands.
        seat.settle_height(object, &mut as_input);
        let set_down = |pose| {
            let mut layout = as_input.clone();
            seat.carry(object, pose, &mut layout);
            layout
        };
        Ok(seat.rests_among_others(object, &as_input)?.into_iter().map(set_down).collect())
    }

    fn to_set_anew(&self, trial: &Trial) -> Vec<usize> {
        let rolls = |&object: &usize| self.run.rolling.contains(&object) || self.fell(object, &trial.layout[object]);
        trial.failing.iter().copied().filter(rolls).collect()
    }
}
