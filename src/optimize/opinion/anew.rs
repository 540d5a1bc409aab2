//! What rolls or has fallen over, set down anew: where it is, as it was reconstructed, leaning on what is there. A pear
//! that is let go comes to rest in few poses, and no random turn finds them.

use super::tolerances::{FAR_OFF, FINALISTS_OF_ONE, POSES};
use super::{Event, Layout, Observer, Opinions, cheaper, finalists, trial::Trial};
use crate::world::{BackendError, Flow};

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
            if let Some(anew) = self.run.set_down_among_others(object, &layout, 1)?.pop() {
                layout = anew;
            }
        }
        Ok((!objects.is_empty()).then_some(layout))
    }

    /// The best layout with all that fails and rolls or has fallen over set down anew, over and over at most so many times,
    /// until none of it finds a better place.
    pub(super) fn each_anew(
        &self,
        mut best: Trial,
        times: usize,
        observer: &mut dyn Observer,
    ) -> Result<Trial, BackendError> {
        let mut in_vain = 0;
        for _ in 0..times {
            let objects = self.to_set_anew(&best);
            if in_vain >= objects.len() || self.tells(objects.len(), observer) == Flow::Stop {
                break;
            }
            for &object in &objects {
                let better = if in_vain < objects.len() { self.anew(&best, object)? } else { None };
                in_vain = if better.is_some() { 0 } else { in_vain + 1 };
                best = better.unwrap_or(best);
            }
        }
        Ok(best)
    }

    /// The same once with what rolls and has come to stand far from how it was set onto its support, the farthest first:
    /// what was in its place may have gone.
    pub(super) fn far_anew(&self, mut best: Trial, observer: &mut dyn Observer) -> Result<Trial, BackendError> {
        let cost = |object: &usize| best.costs[*object];
        let is_far = |object: &usize| !best.failing.contains(object) && cost(object) > FAR_OFF;
        let mut far: Vec<usize> = self.run.rolling.iter().copied().filter(is_far).collect();
        far.sort_by(|a, b| cost(b).total_cmp(&cost(a)));
        if !far.is_empty() && self.tells(far.len(), observer) == Flow::Continue {
            for object in far {
                best = self.anew(&best, object)?.unwrap_or(best);
            }
        }
        Ok(best)
    }

    fn tells(&self, objects: usize, observer: &mut dyn Observer) -> Flow {
        observer.event(Event::SettingAnew { objects })
    }

    /// The layout with an object set down anew in the pose with which the whole costs least, if it costs less than before.
    fn anew(&self, best: &Trial, object: usize) -> Result<Option<Trial>, BackendError> {
        if self.flow() == Flow::Stop {
            return Ok(None);
        }
        let layouts = self.run.set_down_among_others(object, &best.layout, POSES)?;
        let focused = self.focused(best, &[&best.failing[..], &[object]].concat());
        let trials = focused.judge_copies(focused.settled(&focused.settling, &layouts)?, best)?;
        let finalists = finalists(trials, best, FINALISTS_OF_ONE);
        let trials = self.judge(self.settled(&self.settling, &finalists)?)?;
        Ok(cheaper(trials, best).filter(|_| self.flow() == Flow::Continue))
    }

    fn to_set_anew(&self, trial: &Trial) -> Vec<usize> {
        let rolls = |&object: &usize| self.run.rolling.contains(&object) || self.fell(object, &trial.layout[object]);
        trial.failing.iter().copied().filter(rolls).collect()
    }
}
