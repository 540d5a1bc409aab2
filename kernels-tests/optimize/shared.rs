//! Things that lean, and things that stand on more than their parent.

use crate::fixture::*;
use glam::{DVec3, Vec3};
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::optimize::ObjectOutcome;
use rest3d_gpu::scene::Parent;

/// What becomes of the last two objects, without and with a search.
fn last_two(boxes: &Boxes) -> [ObjectOutcome; 4] {
    let ends = [frozen(), config()].map(|mut config| {
        config.seat = true;
        simple(boxes, &CpuBackend, &config).objects
    });
    let [a, b] = ends.map(|objects| [objects[objects.len() - 2].clone(), objects[objects.len() - 1].clone()]);
    let ([a, b], [c, d]) = (a, b);
    [a, b, c, d]
}

#[test]
fn a_board_stays_on_two_stools() {
    for [height, fixed] in [[0.5, 0.0], [0.49, 0.0], [0.52, 0.0], [0.5, 1.0]] {
        let mut boxes = Boxes::default();
        let stool = boxes.add("stool", GROUND, Vec3::new(0.3, 0.5, 0.3), DVec3::new(-0.6, 0.0, 0.0));
        // The scene says that the board is on one of them, and lists the other last but for what is on the board.
        let other = boxes.add("other", GROUND, Vec3::new(0.3, height as f32, 0.3), DVec3::new(0.6, 0.0, 0.0));
        let board = boxes.add("board", Parent::Object(stool), Vec3::new(1.6, 0.03, 0.3), DVec3::new(0.0, 0.502, 0.0));
        boxes.add("vase", Parent::Object(board), Vec3::new(0.1, 0.2, 0.1), DVec3::new(0.2, 0.532, 0.0));
        boxes.objects[stool].movable = fixed == 0.0;
        boxes.objects[other].movable = fixed == 0.0;
        for object in last_two(&boxes) {
            assert!(object.stable && !object.lost_support, "{height} m: {object:?}");
            assert!(object.moved < 0.04 && object.turned < 0.05, "{height} m: {object:?}");
        }
    }
}

#[test]
fn a_board_does_not_stay_on_a_stool_that_is_too_low() {
    let mut boxes = Boxes::default();
    let stool = boxes.add("stool", GROUND, Vec3::new(0.3, 0.5, 0.3), DVec3::new(-0.6, 0.0, 0.0));
    boxes.add("other", GROUND, Vec3::new(0.3, 0.3, 0.3), DVec3::new(0.6, 0.0, 0.0));
    boxes.add("board", Parent::Object(stool), Vec3::new(1.6, 0.03, 0.3), DVec3::new(0.0, 0.5, 0.0));
    let [_, board, ..] = last_two(&boxes);
    assert!(board.moved > 0.1, "{board:?}");
}

#[test]
fn a_broom_keeps_leaning_on_a_wardrobe() {
    let mut boxes = Boxes::default();
    boxes.add("wardrobe", GROUND, Vec3::new(0.6, 2.0, 1.0), DVec3::new(-0.3, 0.0, 0.0));
    boxes.add("chair", GROUND, Vec3::splat(0.4), DVec3::new(3.0, 0.0, 0.0));
    let broom = boxes.add("broom", GROUND, Vec3::new(0.05, 1.4, 0.05), DVec3::ZERO);
    // By 15° against its face, at x = 0, with 3 mm between them and 2 mm above the ground.
    let (lean, [half_width, half_height]) = (15_f64.to_radians(), [0.025, 0.7]);
    let (sin, cos) = lean.sin_cos();
    let middle =
        DVec3::new(half_height * sin + half_width * cos + 0.003, half_height * cos + half_width * sin + 0.002, 0.0);
    boxes.turn(broom, lean, middle);
    let [_, resting, _, searched] = last_two(&boxes);
    for broom in [resting, searched] {
        assert!(broom.stable && broom.moved < 0.03 && broom.turned < 0.06, "{broom:?}");
    }
}

#[test]
fn what_rights_itself_keeps_its_place_and_so_does_what_is_on_it() {
    let mut boxes = Boxes::default();
    let size = Vec3::new(0.6, 2.0, 0.5);
    let wardrobe = boxes.add("wardrobe", GROUND, size, DVec3::ZERO);
    boxes.add("suitcase", Parent::Object(wardrobe), Vec3::new(0.4, 0.2, 0.3), DVec3::new(0.0, 2.0, 0.0));
    // About its lower edge its middle would go 52 mm aside, its top and the suitcase 105 mm.
    let lean = 3_f64.to_radians();
    boxes.turn(wardrobe, lean, DVec3::new(0.0, 1.0, 0.0));
    let [wardrobe, suitcase, searched, on_it] = last_two(&boxes);
    for (object, turned) in [(wardrobe, lean), (suitcase, 0.0), (searched, lean), (on_it, 0.0)] {
        assert!(object.stable && (object.turned - turned).abs() < 0.01, "{object:?}");
        assert!(object.moved < 0.02, "{object:?}");
    }
}
