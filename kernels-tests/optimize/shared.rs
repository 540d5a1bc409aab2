//! Things that lean, and things that stand on more than their parent.

use crate::fixture::*;
use glam::{DVec3, Vec3};
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::optimize::{Config, ObjectOutcome};
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
    // A thicker thing leans by chance if it is as far from the wardrobe.
    for (width, gap, leans) in [(0.05, 0.003, true), (0.05, 0.09, true), (0.3, 0.003, true), (0.3, 0.09, false)] {
        let mut boxes = Boxes::default();
        // It floats by 3 mm, the broom by 2: it is set first all the same.
        boxes.add("wardrobe", GROUND, Vec3::new(0.6, 2.0, 1.0), DVec3::new(-0.3, 0.003, 0.0));
        boxes.add("chair", GROUND, Vec3::splat(0.4), DVec3::new(3.0, 0.0, 0.0));
        let broom = boxes.add("broom", GROUND, Vec3::new(width, 1.4, width), DVec3::ZERO);
        // By 15° against its face, at x = 0, a little above the ground.
        let (lean, [half_width, half_height]) = (15_f64.to_radians(), [0.5 * f64::from(width), 0.7]);
        let (sin, cos) = lean.sin_cos();
        let middle =
            DVec3::new(half_height * sin + half_width * cos + gap, half_height * cos + half_width * sin + 0.002, 0.0);
        boxes.turn(broom, lean, middle);
        let [_, resting, _, searched] = last_two(&boxes);
        for broom in [resting, searched] {
            assert!(broom.stable, "{width} m wide: {broom:?}");
            let turned = if leans { gap / (2.0 * half_height) } else { lean };
            assert!((broom.turned - turned).abs() < 0.06, "{width} m wide, {gap} m away: {broom:?}");
        }
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
    // So few candidates leave a few hundredths of what the search turns at random.
    for (object, turned, noise) in
        [(wardrobe, lean, 0.01), (suitcase, 0.0, 0.01), (searched, lean, 0.05), (on_it, 0.0, 0.05)]
    {
        assert!(object.stable && (object.turned - turned).abs() < noise, "{object:?}");
        assert!(object.moved < 0.02, "{object:?}");
    }
}

#[test]
fn a_leaning_board_finds_both_its_stools() {
    let mut boxes = Boxes::default();
    let stool = boxes.add("stool", GROUND, Vec3::new(0.3, 0.5, 0.3), DVec3::new(-0.6, 0.0, 0.0));
    boxes.add("other", GROUND, Vec3::new(0.3, 0.5, 0.3), DVec3::new(0.6, 0.0, 0.0));
    let board = boxes.add("board", Parent::Object(stool), Vec3::new(1.6, 0.03, 0.3), DVec3::new(0.0, 0.5, 0.0));
    boxes.add("vase", Parent::Object(board), Vec3::new(0.1, 0.2, 0.1), DVec3::new(0.2, 0.53, 0.0));
    // On the one stool, it would be 9 cm above the other.
    let lean = 4.5_f64.to_radians();
    boxes.turn(board, lean, DVec3::new(0.0, 0.515, 0.0));
    let [board, vase, searched, on_it] = last_two(&boxes);
    for (object, turned) in [(board, lean), (vase, 0.0), (searched, lean), (on_it, 0.0)] {
        assert!(object.stable && !object.lost_support, "{object:?}");
        assert!(object.moved < 0.03 && (object.turned - turned).abs() < 0.03, "{object:?}");
    }
}

#[test]
fn what_leans_at_an_edge_is_set_upright_on_the_table() {
    // A picture that would fall off from where it is, and onto the table 17 cm farther in; a lamp that has to be moved, too.
    let (picture, lamp) = (Vec3::new(0.03, 0.5, 0.6), Vec3::new(0.1, 0.6, 0.1));
    for (size, x, way, outwards) in [(picture, 0.3, 0.02, 1.0), (lamp, 0.43, 0.11, 1.0), (lamp, 0.43, 0.11, -1.0)] {
        let mut boxes = Boxes::default();
        let table = boxes.add("table", GROUND, Vec3::new(0.8, 0.7, 0.8), DVec3::ZERO);
        let thing = boxes.add("thing", Parent::Object(table), size, DVec3::new(x, 0.7, 0.0));
        let lean = 11_f64.to_radians();
        boxes.turn(thing, -lean * outwards, DVec3::new(x, 0.71 + 0.5 * f64::from(size.y), 0.0));
        let [_, seated, _, searched] = last_two(&boxes);
        for thing in [seated, searched] {
            assert!(thing.stable && !thing.lost_support, "{thing:?}");
            assert!(thing.moved < way && (thing.turned - lean).abs() < 0.03, "{thing:?}");
        }
    }
}

#[test]
fn a_pile_stays_one_though_all_of_it_names_the_table() {
    let mut boxes = Boxes::default();
    let table = Parent::Object(boxes.add("table", GROUND, Vec3::new(1.0, 0.7, 0.6), DVec3::ZERO));
    // From the top down, 4 mm apart; the card is sunk into the board that it lies on, down to the table.
    boxes.add("third", table, Vec3::new(0.2, 0.03, 0.15), DVec3::new(-0.2, 0.768, 0.0));
    boxes.add("second", table, Vec3::new(0.25, 0.03, 0.2), DVec3::new(-0.21, 0.734, 0.0));
    boxes.add("first", table, Vec3::new(0.25, 0.03, 0.2), DVec3::new(-0.19, 0.7, 0.0));
    boxes.add("card", table, Vec3::new(0.09, 0.003, 0.06), DVec3::new(0.3, 0.7, 0.0));
    boxes.add("board", table, Vec3::new(0.22, 0.02, 0.18), DVec3::new(0.3, 0.6995, 0.0));
    let objects = simple(&boxes, &CpuBackend, &Config { seat: true, ..frozen() }).objects;
    for (i, height) in [0.76, 0.73, 0.7, 0.72, 0.7].into_iter().enumerate() {
        let object = &objects[i + 1];
        assert!(object.stable && !object.lost_support && object.moved < 0.025, "{object:?}");
        assert!((boxes.foot(i + 1, object) - height).abs() < 2e-3, "{height} m: {object:?}");
    }
}

#[test]
fn what_stands_side_by_side_is_no_pile() {
    let mut boxes = Boxes::default();
    let table = Parent::Object(boxes.add("table", GROUND, Vec3::new(1.0, 0.7, 0.6), DVec3::ZERO));
    // Two cups that are in each other by more than half, and a book that is in another one by less.
    boxes.add("cup", table, Vec3::splat(0.08), DVec3::new(-0.2, 0.7, 0.0));
    boxes.add("book", table, Vec3::new(0.2, 0.012, 0.15), DVec3::new(0.2, 0.7, 0.0));
    boxes.add("another cup", table, Vec3::splat(0.08), DVec3::new(-0.17, 0.7, 0.0));
    boxes.add("another book", table, Vec3::new(0.2, 0.012, 0.15), DVec3::new(0.313, 0.7, 0.0));
    for (i, object) in last_two(&boxes).iter().enumerate() {
        // Where books part, one comes to lean on the other's edge, as in other engines.
        let level = if i % 2 == 0 { 0.05 } else { 0.15 };
        assert!(object.stable && object.turned < level, "{object:?}");
        assert!((boxes.foot(3 + i % 2, object) - 0.7).abs() < 2e-3, "{object:?}");
    }
}
