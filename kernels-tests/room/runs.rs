//! What walls change of a run, to the bit.

use crate::common::scenes::Keep;
use crate::fixture::*;
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::optimize::{Checkpoint, Config, run};

#[test]
fn a_guess_that_nothing_needs_changes_no_bit() {
    let mut boxes = Boxes::new(0.3);
    boxes.add("cabinet", "ground-wall", [0.5, 1.2, 1.4], [-2.2, 0.62, 0.2], -0.03, 0.02);
    boxes.add("box", "cabinet", [0.2, 0.2, 0.2], [-2.2, 1.33, 0.2], 0.2, 0.0);
    boxes.add("table", "ground", [1.6, 0.7, 0.8], [0.3, 0.34, 0.4], 0.02, 0.0);
    let ready = boxes.done();
    let with = ready.run(&config()).outcome;
    let without = ready.run(&Config { room: false, ..config() }).outcome;
    assert!(with.room.sides.is_empty());
    assert_eq!(with.objects, without.objects);
}

#[test]
fn a_picture_needs_its_own_wall_only() {
    let mut boxes = Boxes::new(0.3);
    boxes.add("cabinet", "ground-wall", [0.5, 1.2, 1.4], [-2.2, 0.62, 0.2], -0.03, 0.02);
    boxes.add("table", "ground", [1.6, 0.7, 0.8], [0.3, 0.34, 0.4], 0.02, 0.0);
    boxes.add("picture", "wall", [0.8, 0.5, 0.03], [0.2, 1.5, -1.93], 0.12, 0.05);
    let ready = boxes.done();
    let with = ready.run(&config()).outcome;
    let without = ready.run(&Config { room: false, ..config() }).outcome;
    assert_eq!(with.room.sides.len(), 1, "{:?}", with.room.sides);
    assert_eq!(with.objects[..2], without.objects[..2], "the cabinet stands at no wall that is known");
    assert_ne!(with.objects[2].pose, without.objects[2].pose, "the picture has been put onto its wall");
}

#[test]
fn a_run_with_walls_repeats_and_resumes_to_the_bit() {
    let ready = furnished(0.3).with_room(2.5).done();
    let mut keep = Keep::default();
    let mut go = |resume| run(&ready.scene, &ready.shapes, &CpuBackend, &config(), 1, resume, &mut keep).unwrap();
    let first = go(None);
    assert_eq!(first.objects, go(None).objects);
    let checkpoint = Checkpoint::from_json(&keep.0[0]).unwrap();
    let resumed = run(&ready.scene, &ready.shapes, &CpuBackend, &config(), 1, Some(checkpoint), &mut Keep::default());
    let resumed = resumed.unwrap();
    assert_eq!((first.objects, first.placements), (resumed.objects, resumed.placements));
}
