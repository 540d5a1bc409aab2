//! Copies of a layout in which what does not stand is elsewhere.

use super::tolerances::{COPIES, SPREAD};
use super::{Layout, Opinions, runs::Model, trial::Trial};
use crate::cpu::sample::sample;
use crate::world::{BackendError, Stream};
use glam::{DQuat, Vec3};

impl Opinions<'_> {
    /// Copies of a layout in which what moves is shifted and turned, in every other one from where it comes to rest in
    /// one of the runs. What has lost its support is set onto it again in all, what leans or has fallen in half of
    /// them: it may do so for good, and take others along.
    pub(super) fn copies(&self, trial: &Trial, round: u32) -> Result<Vec<Layout>, BackendError> {
        let settled = |model: &Model| Ok(self.settled(model, std::slice::from_ref(&trial.layout))?.swap_remove(0));
        let elsewhere: Vec<Layout> = self.beside(1, &self.models[1..], settled)?;
        let places: Vec<Layout> =
            trial.astray.iter().map(|&object| self.run.free_places(object, &trial.layout)).collect();
        let copy = |copy| {
            let mut layout = trial.layout.clone();
            let mut objects = trial.moving.clone();
            if copy % 2 == 1 {
                let elsewhere = &elsewhere[copy as usize / 2 % elsewhere.len()];
                objects.iter().for_each(|&object| layout[object] = elsewhere[object]);
            } else if copy % 4 == 2 {
                // As they were reconstructed, where they are.
                for &object in &objects {
                    layout[object] = self.run.rigs[object].turned(&layout[object], self.run.input[object].rotation);
                }
            }
            if !trial.lost.is_empty() || trial.moving.is_empty() || copy % 4 < 2 {
                objects.clone_from(&trial.failing);
                for (&object, places) in trial.astray.iter().zip(&places) {
                    if let Some(place) = places.get(copy as usize * places.len() / COPIES as usize) {
                        layout[object] = *place;
                        // It was set down there in a pose of rest: any tilt, and a pear rolls off again.
                        objects.retain(|&other| other != object);
                    }
                }
            }
            self.perturb(&mut layout, &objects, round, copy);
            layout
        };
        Ok((0..COPIES).map(copy).collect())
    }

    /// Shifts and turns the objects about their centres of mass; the first two copies stay as they are.
    fn perturb(&self, layout: &mut Layout, objects: &[usize], round: u32, copy: u32) {
        let wide = (copy / 2) as f32 / (COPIES / 2 - 1) as f32;
        let std = SPREAD.map(|std| wide * std).repeat(objects.len());
        let mut noise = vec![0.0; std.len()];
        let stream = Stream { seed: self.run.seed, stage: self.run.groups.len() as u32 };
        sample(&vec![0.0; std.len()], &std, stream, round, copy, &mut noise);
        for (&object, noise) in objects.iter().zip(noise.chunks_exact(SPREAD.len())) {
            let turn = DQuat::from_scaled_axis(Vec3::from_slice(&noise[3..]).as_dvec3());
            layout[object] = self.run.rigs[object].turned(&layout[object], turn * layout[object].rotation);
            layout[object].translation += Vec3::from_slice(noise).as_dvec3();
        }
    }
}
