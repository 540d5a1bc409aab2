//! What a round simulates: most of a room has nothing to do with the cup that it is about.

use super::{
    Opinions,
    runs::LAPS,
    trial::{Release, Trial},
};
use crate::optimize::{
    groups::{is_on_firm_ground, moving_along},
    support::Placed,
};
use crate::scene::Scene;
use std::sync::Arc;

impl Opinions<'_> {
    /// The same runs in which only those objects move that what is `sought` concerns, V-HACD's for a first look. What came
    /// of the others in the runs of `trial` is taken to come of them again.
    pub(super) fn focused(&self, trial: &Trial, sought: &[usize]) -> Self {
        let placed = self.run.rigs.iter().zip(&trial.layout).map(|(rig, pose)| Placed::new(rig, &rig.body(pose)));
        let placed: Vec<Placed> = placed.collect();
        let moves = concerned(self.run.scene, sought, |a, b| placed[a].touches(&placed[b]));
        let group = self.group.with_moving(&moves);
        let known = trial.released.iter().zip(&moves);
        let models = self.models.iter().map(|model| model.of(&group)).enumerate();
        let models = models.map(|(run, model)| match run < LAPS[0] {
            true => model,
            false => model.hastened(&self.run.config.simulation),
        });
        Self {
            run: self.run,
            stop: Arc::clone(&self.stop),
            models: models.collect(),
            filled: self.filled.clone(),
            settling: self.settling.of(&group),
            known: known.map(|(known, moves)| if *moves { Release::default() } else { *known }).collect(),
            group,
        }
    }
}

/// What fails, what bears it, what stands on it, and what touches any of these; but of what stands on the ground, or on
/// something that never moves, and bears what fails only that which fails itself: the desk under a pile of books stays
/// where it is.
fn concerned(scene: &Scene, failing: &[usize], touches: impl Fn(usize, usize) -> bool) -> Vec<bool> {
    let mut concerned = vec![false; scene.objects.len()];
    let mut fresh: Vec<usize> = failing.to_vec();
    while let Some(object) = fresh.pop() {
        if std::mem::replace(&mut concerned[object], true) {
            continue;
        }
        fresh.extend(moving_along(scene, object));
        let bearers: Vec<usize> = scene.bearers(object).collect();
        let others = (0..concerned.len()).filter(|&other| !concerned[other] && !scene.is_static(other));
        fresh.extend(others.filter(|other| match bearers.contains(other) {
            true => !is_on_firm_ground(scene, *other),
            false => touches(object, *other),
        }));
    }
    concerned
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// What may move when some objects of the demo scene fail, of whose others these pairs touch.
    fn moving(failing: &[&str], touching: &[[&str; 2]]) -> Vec<String> {
        let scene = Scene::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/study")).expect("the demo scene");
        let name = |object: usize| scene.objects[object].name.as_str();
        let failing: Vec<usize> = (0..scene.objects.len()).filter(|&object| failing.contains(&name(object))).collect();
        let touches = |a, b| touching.iter().any(|pair| pair == &[name(a), name(b)] || pair == &[name(b), name(a)]);
        let concerned = concerned(&scene, &failing, touches);
        (0..concerned.len()).filter(|&object| concerned[object]).map(|object| name(object).to_owned()).collect()
    }

    #[test]
    fn the_desk_under_what_fails_is_held_and_what_touches_that_is_not() {
        let touching = [["tv", "desk"], ["tv", "speaker_left"], ["speaker_left", "plant_small"], ["desk", "chair"]];
        assert_eq!(moving(&["tv"], &touching), ["speaker_left", "plant_small", "tv"]);
    }

    #[test]
    fn what_fails_on_the_ground_takes_along_what_is_on_it_and_what_touches_that() {
        assert_eq!(moving(&["stool"], &[["plant_on_stool", "plant"]]), ["stool", "plant_on_stool", "plant"]);
        assert_eq!(moving(&["nightstand", "desk_lamp"], &[]), ["nightstand", "desk_lamp"]);
        assert_eq!(moving(&["plant"], &[["plant", "stool"], ["plant", "radiator"], ["plant", "clock"]]).len(), 4);
    }
}
