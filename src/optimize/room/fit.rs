//! Walls and a ceiling for a scene that has none: along the furniture, and behind what is on them.

use super::outline::{Outline, wrapped};
use super::tolerances::{AGREEMENT, AT_WALL, BOXY, CONTACT, LOWEST_CEILING};
use super::{Form, Side, hangs_on, remoteness, stands};
use crate::scene::{Parent, Pose, Root, Scene};
use glam::{DQuat, DVec3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// The walls that something is on or against. They are parallel to the large furniture; each lies where the median of
/// what is at it has its back, but encloses what stands elsewhere or does not move.
pub(super) fn walls(scene: &Scene, forms: &[Form], layout: &[Pose]) -> Vec<Side> {
    let turn = DQuat::from_rotation_y(yaw(scene, forms, layout));
    let normals = [0.0, FRAC_PI_2, -FRAC_PI_2, PI].map(|angle| turn * (DQuat::from_rotation_y(angle) * DVec3::Z));
    let back = |i: usize, normal: DVec3| forms[i].mesh(&layout[i]).map(|p| p.dot(normal)).fold(f64::INFINITY, f64::min);
    let everything = || 0..layout.len();
    let ends = normals.map(|normal| everything().map(|i| back(i, normal)).fold(f64::INFINITY, f64::min));
    let mut on_side = [const { Vec::new() }; 4];
    for i in everything().filter(|&i| is_at_wall(scene, i)) {
        let hangs = hangs_on(scene, i).is_some();
        let remote = |side: usize| remoteness(&forms[i], &layout[i], hangs, normals[side], normals[side] * ends[side]);
        let nearest = (0..4).min_by(|&a, &b| remote(a).total_cmp(&remote(b)));
        nearest.into_iter().for_each(|side| on_side[side].push(i));
    }
    let side = |(normal, on): (DVec3, &Vec<usize>)| {
        let mut backs: Vec<f64> = on.iter().map(|&i| back(i, normal)).collect();
        backs.sort_by(f64::total_cmp);
        let median = backs.get(backs.len() / 2).copied().unwrap_or(f64::INFINITY);
        // What moves is put against its wall; anything else on the ground stands inside.
        let is_put = |i: usize| on.contains(&i) && scene.objects[i].movable;
        let on_ground = |i: usize| stands(scene, i) || (on.contains(&i) && hangs_on(scene, i).is_none());
        let enclosed = |&i: &usize| on_ground(i) && !is_put(i);
        let end = everything().filter(enclosed).map(|i| back(i, normal)).fold(median, f64::min) - CONTACT;
        let (name, point) = (name(normal).to_owned(), normal * end);
        (!on.is_empty()).then_some(Side {
            name,
            kind: Root::Wall,
            point,
            normal,
            fitted: true,
            bears: false,
            leant_on: false,
        })
    };
    normals.into_iter().zip(&on_side).filter_map(side).collect()
}

/// The height of a ceiling over everything, m.
pub(super) fn ceiling(forms: &[Form], layout: &[Pose]) -> f64 {
    let tops = forms.iter().zip(layout).map(|(form, pose)| form.bounds(pose)[1].y);
    tops.fold(LOWEST_CEILING, f64::max)
}

fn is_at_wall(scene: &Scene, i: usize) -> bool {
    matches!(scene.objects[i].parent, Parent::Root(Root::Wall | Root::GroundWall))
}

/// The yaw that most furniture has, modulo a right angle, rad: long rectangular outlines count most, and what is at a
/// wall twice.
fn yaw(scene: &Scene, forms: &[Form], layout: &[Pose]) -> f64 {
    let votes: Vec<(f64, f64)> = (0..layout.len())
        .filter(|&i| matches!(scene.objects[i].parent, Parent::Root(root) if root != Root::Ceiling))
        .filter_map(|i| {
            let rectangle = Outline::new(forms[i].mesh(&layout[i])).rectangle()?;
            let boxy = ((rectangle.filled - BOXY[0]) / (BOXY[1] - BOXY[0])).clamp(0.0, 1.0);
            let weight = rectangle.length.powi(2) * boxy * if is_at_wall(scene, i) { AT_WALL } else { 1.0 };
            Some((rectangle.yaw, weight))
        })
        .collect();
    let near = |yaw: f64| {
        let apart = votes.iter().map(move |&(other, weight)| (wrapped(other - yaw, FRAC_PI_2), weight));
        apart.map(|(apart, weight)| (apart, weight * (1.0 - apart.abs() / AGREEMENT).max(0.0)))
    };
    let support = |yaw: f64| near(yaw).map(|(_, weight)| weight).sum::<f64>();
    let supported = votes.iter().map(|&(yaw, _)| (yaw, support(yaw))).filter(|&(_, support)| support > 0.0);
    // Of two equals the first: max_by would take the last.
    let best = supported.reduce(|best, next| if next.1 > best.1 { next } else { best });
    best.map_or(0.0, |(yaw, support)| {
        let mean = yaw + near(yaw).map(|(apart, weight)| apart * weight).sum::<f64>() / support;
        wrapped(mean, FRAC_PI_2)
    })
}

/// What a wall is called: a scene is seen along −Z.
fn name(normal: DVec3) -> &'static str {
    let yaw = normal.x.atan2(normal.z);
    match (yaw.abs() <= FRAC_PI_4, yaw.abs() >= PI - FRAC_PI_4, yaw > 0.0) {
        (true, ..) => "back",
        (_, true, _) => "front",
        (.., true) => "left",
        (.., false) => "right",
    }
}
