//! Contacts that are known by hand.

use crate::common::hulls::{cuboid, prism};
use crate::fixture::*;
use glam::{Quat, Vec3};
use rest3d_gpu::cpu::narrow_phase::*;
use rest3d_gpu::world::{HullTables, NarrowPhase, Pose};

fn upright(height: f32) -> [Pose; 2] {
    [Pose::IDENTITY, Pose::new(Quat::IDENTITY, Vec3::new(0.0, height, 0.0))]
}

const BOTH: [NarrowPhase; 2] = [NarrowPhase::Twin, NarrowPhase::Reference];

#[test]
fn box_on_box_touches_at_its_four_corners() {
    let (lower, upper) = (cuboid(Vec3::new(0.3, 0.1, 0.2)), cuboid(Vec3::new(0.1, 0.05, 0.08)));
    for gap in [0.004, 1e-6, -1e-6, -0.001, -0.03] {
        let case = Case::new([&lower, &upper], upright(0.15 + gap));
        for kind in BOTH {
            let m = case.manifold(kind);
            assert_eq!(m.count, 4, "{kind:?} at {gap}");
            assert!(m.normal.distance(Vec3::Y) < 1e-3, "{kind:?} at {gap}: {m:?}");
            for p in m.points() {
                assert!((p.separation - gap).abs() < 2e-6, "{kind:?} at {gap}: {m:?}");
                assert!((p.on_b.x.abs() - 0.1).abs() < 1e-5 && (p.on_b.z.abs() - 0.08).abs() < 1e-5);
                assert!((p.on_a.y - 0.1).abs() < 1e-6 && (p.on_b.y - 0.1 - gap).abs() < 1e-5);
            }
        }
    }
}

#[test]
fn equal_boxes_meet_at_four_corners_and_coincident_ones_part_along_the_shortest_side() {
    let shape = cuboid(Vec3::new(0.3, 0.1, 0.2));
    for kind in BOTH {
        let m = Case::new([&shape, &shape], upright(0.2 - 1e-4)).manifold(kind);
        assert_eq!(m.count, 4, "{kind:?}");
        let coincident = Case::new([&shape, &shape], upright(0.0));
        let s = coincident.separation(kind).unwrap();
        assert!((s.distance + 0.2).abs() < 1e-5 && s.normal.y.abs() > 0.999, "{kind:?}: {s:?}");
        assert_eq!(coincident.manifold(kind).count, 4, "{kind:?}");
    }
}

#[test]
fn octagonal_prism_on_a_plate_keeps_all_eight_corners() {
    for kind in BOTH {
        let case = Case::new([&cuboid(Vec3::new(0.5, 0.01, 0.5)), &prism(0.1, 0.1, 8)], upright(0.11 - 2e-4));
        let m = case.manifold(kind);
        assert_eq!(m.count, 8, "{kind:?}");
        assert!(m.points().iter().all(|p| (p.separation + 2e-4).abs() < 2e-6), "{kind:?}: {m:?}");
    }
}

#[test]
fn crossing_edges_meet_in_one_point() {
    let shape = cuboid(Vec3::splat(0.1));
    let lower = Quat::from_rotation_z(std::f32::consts::FRAC_PI_4);
    let upper = Quat::from_rotation_x(std::f32::consts::FRAC_PI_4);
    for gap in [0.003, -0.002] {
        let height = 0.2 * std::f32::consts::SQRT_2 + gap;
        let poses = [Pose::new(lower, Vec3::ZERO), Pose::new(upper, Vec3::new(0.02, height, 0.03))];
        let case = Case::new([&shape, &shape], poses);
        for kind in BOTH {
            let m = case.manifold(kind);
            assert_eq!(m.count, 1, "{kind:?}");
            let p = m.points()[0];
            assert!((p.separation - gap).abs() < 1e-5 && m.normal.y > 0.9999, "{kind:?}: {m:?}");
            let expected = Vec3::new(0.02, 0.1 * std::f32::consts::SQRT_2, 0.03);
            // The lower box's edge runs along z at x = 0, the upper one's along x at z = 0.03.
            assert!((p.on_a - Vec3::new(0.0, expected.y, 0.03)).length() < 1e-4, "{kind:?}: {m:?}");
        }
    }
}

#[test]
fn boxes_diagonally_apart_have_no_false_contact() {
    let shape = cuboid(Vec3::splat(0.1));
    for (gap, near) in [(0.008, false), (0.005, true)] {
        // Corner to corner: each axis separates by `gap`, the distance is √3 times that.
        let poses = [Pose::IDENTITY, Pose::new(Quat::IDENTITY, Vec3::splat(0.2 + gap))];
        let case = Case::new([&shape, &shape], poses);
        for kind in BOTH {
            let m = case.manifold(kind);
            assert_eq!(m.count, u32::from(near), "{kind:?} at {gap}: {m:?}");
            if near {
                let p = m.points()[0];
                assert!((p.separation - gap * 3.0_f32.sqrt()).abs() < 1e-5, "{kind:?}: {m:?}");
                assert!(m.normal.distance(Vec3::splat(1.0 / 3.0_f32.sqrt())) < 1e-3, "{kind:?}: {m:?}");
            }
        }
    }
}

#[test]
fn swallowed_boxes_and_plates_leave_by_the_nearest_side() {
    let outer = cuboid(Vec3::new(0.5, 0.3, 0.4));
    for inner in [cuboid(Vec3::splat(0.02)), cuboid(Vec3::new(0.1, 0.0005, 0.1)), prism(0.0025, 0.0025, 16)] {
        for kind in BOTH {
            let case = Case::new([&outer, &inner], upright(0.2));
            let s = case.separation(kind).unwrap();
            let expected = -(0.1 + case.tables.hulls[1].half_extents.y);
            assert!((s.distance - expected).abs() < 2e-5 && s.normal.y > 0.9999, "{kind:?}: {s:?}, not {expected}");
            assert!(case.manifold(kind).count >= 4, "{kind:?}");
        }
    }
}

#[test]
fn the_way_into_the_ground_is_a_detour() {
    // A cube 0.04 m wide in a box of 1 m: 0.1 m from its bottom, 0.3 m from one side.
    let parts = [cuboid(Vec3::splat(0.5)), cuboid(Vec3::splat(0.02))];
    let at = Vec3::new(0.18, -0.38, 0.0);
    let case = Case::new([&parts[0], &parts[1]], [Pose::IDENTITY, Pose::new(Quat::IDENTITY, at)]);
    let narrow = case.separator(NarrowPhase::Twin);
    // From either side, and with an axis that was the best before the ground was known.
    for (pair, sign) in [(case.pair(), 1.0), (case.swapped(), -1.0)] {
        let mut cache = PairCache::default();
        let mut least = |room: f32| {
            let room = if sign > 0.0 { [f32::MAX, room] } else { [room, f32::MAX] };
            let s = narrow.separation(&HullPair { room, ..pair }, MARGIN, &mut cache).unwrap();
            (sign * s.normal, s.distance)
        };
        // 0.14 m down, or 0.34 m aside.
        for (room, expected, depth) in [(f32::MAX, -Vec3::Y, 0.14), (0.15, -Vec3::Y, 0.14), (0.13, Vec3::X, 0.34)] {
            let (normal, distance) = least(room);
            assert!(normal.distance(expected) < 1e-6 && (distance + depth).abs() < 1e-5, "{room}: {normal} {distance}");
        }
        assert!((narrow.depth(&pair, 0.0) - 0.14).abs() < 1e-5);
    }
}

#[test]
fn a_bottom_of_two_facets_rests_on_both() {
    // Two facets 2° apart, too far from one plane to be joined: a wide wedge under a block, lying on a table.
    let sag = 0.1 * 1.0_f32.to_radians().tan();
    let mut points = cuboid(Vec3::new(0.1, 0.05, 0.05));
    points.extend([Vec3::new(0.0, -0.05 - sag, 0.05), Vec3::new(0.0, -0.05 - sag, -0.05)]);
    let case = Case::new([&cuboid(Vec3::new(0.5, 0.05, 0.5)), &points], upright(0.1 + sag - 1e-4));
    for kind in BOTH {
        let m = case.manifold(kind);
        let (low, high) = m.points().iter().fold((0.0_f32, 0.0_f32), |(l, h), p| (l.min(p.on_b.x), h.max(p.on_b.x)));
        assert!(low < -0.09 && high > 0.09, "{kind:?}: {m:?}");
        assert_eq!(m.count, 6, "{kind:?}: shared corners once: {m:?}");
    }
}

#[test]
fn a_plane_sees_the_corners_of_the_footprint() {
    let mut tables = HullTables::default();
    tables.push(&prism(0.1, 0.002, 8));
    tables.push(&prism(0.1, 0.002, 30));
    let mut out = Manifold::default();
    let pose = Pose::new(Quat::IDENTITY, Vec3::new(1.0, 0.502, 0.0));
    plane_hull(&tables, 0, &pose, (Vec3::Y, 0.5), MARGIN, &mut out);
    assert_eq!(out.count, 8, "the top of a thin plate lies within the margin but adds no support");
    assert!(out.points().iter().all(|p| p.separation.abs() < 1e-6 && (p.on_a.y - 0.5).abs() < 1e-6));
    plane_hull(&tables, 1, &pose, (Vec3::Y, 0.5), MARGIN, &mut out);
    assert_eq!(out.count, 8);
    assert!(out.points().iter().all(|p| p.separation.abs() < 1e-6), "{out:?}");
    let tilted = Pose::new(Quat::from_rotation_z(0.3), Vec3::new(1.0, 0.5, 0.0));
    plane_hull(&tables, 1, &tilted, (Vec3::Y, 0.5), MARGIN, &mut out);
    let deepest = |heights: &mut dyn Iterator<Item = f32>| heights.fold(1.0, f32::min);
    let expected =
        deepest(&mut tables.vertices_of(&tables.hulls[1]).iter().map(|v| tilted.point(v.truncate()).y - 0.5));
    let found = deepest(&mut out.points().iter().map(|p| p.separation));
    // Two corners are deepest, and their neighbours 1.3 mm higher: points within a millimetre are interchangeable.
    assert!((found - expected).abs() < 1e-6, "{found}, not {expected}");
    plane_hull(&tables, 0, &pose, (Vec3::Y, 0.48), MARGIN, &mut out);
    assert_eq!(out.count, 0);
}

#[test]
fn reduction_keeps_the_outline_of_what_bears() {
    let circle = |radius: f32| {
        (0..24).map(move |i| {
            let (sin, cos) = (i as f32 / 24.0 * std::f32::consts::TAU).sin_cos();
            radius * Vec3::new(cos, 0.0, -sin)
        })
    };
    let inside = (0..20).map(|i| Vec3::new(0.002 * i as f32, 0.0, -0.03));
    let points: Vec<Vec3> = circle(0.1).chain(inside).collect();
    let kept = reduce(points.len(), |i| (points[i], 0.0), Vec3::Y);
    let corner = |k: usize| points[kept.indices()[k % kept.indices().len()] as usize];
    let area: f32 = (0..kept.indices().len()).map(|k| 0.5 * corner(k).cross(corner(k + 1)).y).sum();
    // The 24-gon has 0.0311 m², the best octagon 0.0283.
    assert!(kept.indices().len() == 8 && area > 0.027, "area {area}");
    // A ring that touches inside a wider one with a gap of 5 mm.
    let points: Vec<Vec3> = circle(0.11).chain(circle(0.1)).collect();
    let kept = reduce(points.len(), |i| (points[i], if i < 24 { 0.005 } else { 0.0 }), Vec3::Y);
    assert!(kept.indices().iter().all(|&i| i >= 24), "{:?}", kept.indices());
}

#[test]
fn reduction_keeps_corners_that_are_farthest_in_no_direction() {
    // A foot cut off by an edge of three pieces; the two corners between them are 6 mm beyond its ends.
    let foot = [[0.0, -0.1], [0.006, -0.04], [0.006, 0.04], [0.0, 0.1], [-0.1, 0.04], [-0.1, -0.04]];
    let inside = (0..20).map(|i| [-0.003 * i as f32, 0.02]);
    let flat: Vec<[f32; 2]> = inside.chain(foot).collect();
    for turn in (0..90).map(|degrees| Quat::from_rotation_y((degrees as f32).to_radians())) {
        let points: Vec<Vec3> = flat.iter().map(|&[x, z]| turn * Vec3::new(x, 0.0, z)).collect();
        let kept = reduce(points.len(), |i| (points[i], 0.0), Vec3::Y);
        let mut kept: Vec<u16> = kept.indices().to_vec();
        kept.sort();
        assert_eq!(kept, [20, 21, 22, 23, 24, 25]);
    }
}

#[test]
fn no_finite_pose_no_contact() {
    let shape = cuboid(Vec3::splat(0.1));
    for bad in [f32::NAN, f32::INFINITY] {
        let case = Case::new([&shape, &shape], upright(bad));
        for kind in BOTH {
            assert_eq!(case.separation(kind), None);
            assert_eq!(case.separator(kind).depth(&case.pair(), 0.0), 0.0);
        }
    }
}
