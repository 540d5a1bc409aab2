//! Walls and a ceiling for a scene that has none: along the furniture, and behind what is on them. What stands or hangs
//! astray, a cup that was reconstructed behind the wall or metres above the lamps, moves neither: it must not take all
//! that is on them with it.

use super::outline::{Outline, wrapped};
use super::tolerances::{AGREEMENT, AT_WALL, BOXY, CONTACT, FLAT_ON, LOWEST_CEILING, MAX_INSIDE};
use super::{Form, Side, hangs_on, remoteness, stands};
use crate::scene::{Parent, Pose, Root, Scene};
use glam::{DQuat, DVec3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::iter::once;

/// The walls that something is on or against. They are parallel to the large furniture; each lies where the median of
/// what is at it has its back, but encloses what stands elsewhere or does not move, unless that is astray.
pub(super) fn walls(scene: &Scene, forms: &[Form], layout: &[Pose]) -> Vec<Side> {
    let turn = DQuat::from_rotation_y(yaw(scene, forms, layout));
    let normals = [0.0, FRAC_PI_2, -FRAC_PI_2, PI].map(|angle| turn * (DQuat::from_rotation_y(angle) * DVec3::Z));
    let back = |i: usize, normal: DVec3| forms[i].mesh(&layout[i]).map(|p| p.dot(normal)).fold(f64::INFINITY, f64::min);
    let depth = |i: usize, normal: DVec3| -back(i, -normal) - back(i, normal);
    let middle = |i: usize, normal: DVec3| back(i, normal) + 0.5 * depth(i, normal);
    let hangs_flat = |i: usize, normal: DVec3| {
        let sideways = DVec3::Y.cross(normal);
        hangs_on(scene, i) == Some(Root::Wall) && FLAT_ON * depth(i, normal) <= depth(i, sideways)
    };
    let everything = || 0..layout.len();
    let backs = |objects: &[usize], normal: DVec3| objects.iter().map(|&i| back(i, normal)).collect::<Vec<f64>>();
    // Where a side of the scene ends: where what hangs flat on that side does, else with whatever is farthest out.
    let ends = normals.map(|normal| {
        let mut standing: Vec<f64> = everything().filter(|&i| stands(scene, i)).map(|i| middle(i, normal)).collect();
        standing.sort_by(f64::total_cmp);
        let inner = standing.get(standing.len() / 2).copied().unwrap_or(f64::INFINITY);
        let is_on = |&i: &usize| hangs_flat(i, normal) && middle(i, normal) < inner;
        let (on, others): (Vec<usize>, Vec<usize>) = everything().partition(is_on);
        enclosing(backs(&on, normal), backs(&others, normal))
    });
    let mut on_side = [const { Vec::new() }; 4];
    for i in everything().filter(|&i| is_at_wall(scene, i)) {
        let hangs = hangs_on(scene, i).is_some();
        // What hangs flat does so on a wall behind its back, not on one at its side that happens to be nearer.
        let is_behind = |side: &usize| !hangs_flat(i, DVec3::Y.cross(normals[*side]));
        let remote = |side: usize| remoteness(&forms[i], &layout[i], hangs, normals[side], normals[side] * ends[side]);
        let nearest = (0..4).filter(is_behind).min_by(|&a, &b| remote(a).total_cmp(&remote(b)));
        nearest.into_iter().for_each(|side| on_side[side].push(i));
    }
    let side = |(normal, on): (DVec3, &Vec<usize>)| {
        // What moves is put against its wall; anything else on the ground stands inside.
        let is_put = |i: usize| on.contains(&i) && scene.objects[i].movable;
        let on_ground = |i: usize| stands(scene, i) || (on.contains(&i) && hangs_on(scene, i).is_none());
        let enclosed: Vec<usize> = everything().filter(|&i| on_ground(i) && !is_put(i)).collect();
        let end = enclosing(backs(on, normal), backs(&enclosed, normal)) - CONTACT;
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

/// Where the median of what is on a side is, or farther out, so that it encloses the others, m along its normal into the
/// room. Those more than `MAX_INSIDE` beyond it only count if they are as many as what is on it.
fn enclosing(mut on: Vec<f64>, others: Vec<f64>) -> f64 {
    on.sort_by(f64::total_cmp);
    // Of two in the middle that are far apart the outer one: the other can be moved there, but nothing through the wall.
    let [outer, inner] = [on.len().saturating_sub(1) / 2, on.len() / 2].map(|i| on.get(i).copied());
    let far = outer.zip(inner).is_some_and(|(outer, inner)| inner - outer > MAX_INSIDE);
    let median = if far { outer } else { inner }.unwrap_or(f64::INFINITY);
    let beyond = others.iter().filter(|&&other| other < median - MAX_INSIDE).count();
    let least = if beyond < on.len() { median - MAX_INSIDE } else { f64::NEG_INFINITY };
    others.into_iter().filter(|&other| other >= least).fold(median, f64::min)
}

/// The height of the ceiling on which the median of what hangs there is, and over everything else, m. What stands is
/// taken to be no higher than on what it stands on.
pub(super) fn ceiling(scene: &Scene, forms: &[Form], layout: &[Pose]) -> f64 {
    let bounds: Vec<[DVec3; 2]> = forms.iter().zip(layout).map(|(form, pose)| form.bounds(pose)).collect();
    let piled = |i: usize| once(i).chain(scene.bearers(i)).map(|i| bounds[i][1].y - bounds[i][0].y).sum::<f64>();
    let top = |i: usize| if stands(scene, i) { bounds[i][1].y.min(piled(i)) } else { bounds[i][1].y };
    let (hung, others): (Vec<usize>, Vec<usize>) =
        (0..layout.len()).partition(|&i| scene.objects[i].parent == Parent::Root(Root::Ceiling));
    let below = |objects: Vec<usize>| objects.into_iter().map(|i| -top(i)).collect();
    (-enclosing(below(hung), below(others))).max(LOWEST_CEILING)
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
