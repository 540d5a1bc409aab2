//! What rolls or has fallen over, set down anew: where it is, as it was reconstructed, leaning on what is there. A pear
//! that is let go comes to rest in few poses, and no random turn finds them.

use super::tolerances::{FINALISTS_OF_ONE, POSES};
use super::{Layout, Opinions, cheaper, finalists, trial::Trial};
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

    /// The best layout with these objects set down anew, one after the other, each in the pose with which the whole
    /// costs least, if it costs less than before.
    pub(super) fn one_by_one_anew(&self, mut best: Trial) -> Result<Trial, BackendError> {
        for object in self.to_set_anew(&best) {
            if self.flow() == Flow::Stop {
                break;
            }
            let layouts = self.run.set_down_among_others(object, &best.layout, POSES)?;
            let focused = self.focused(&best);
            let trials = focused.judge_copies(focused.settled(&focused.settling, &layouts)?, &best)?;
            let finalists = finalists(trials, &best, FINALISTS_OF_ONE);
            let trials = self.judge(self.settled(&self.settling, &finalists)?)?;
            if let Some(cheapest) = cheaper(trials, &best).filter(|_| self.flow() == Flow::Continue) {
                best = cheapest;
            }
        }
        Ok(best)
    }

    fn to_set_anew(&self, trial: &Trial) -> Vec<usize> {
        let rolls = |&object: &usize| self.run.rolling.contains(&object) || self.fell(object, &trial.layout[object]);
        trial.failing.iter().copied().filter(rolls).collect()
    }
}
