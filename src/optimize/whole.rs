//! A scene as a whole: the shapes that it asks for, and its world as it stands.

use super::rig::Rig;
use crate::scene::Scene;
use crate::shape::ShapeRequest;
use crate::world::{STATIC, World};
use glam::DVec3;

/// What has to be made into shapes, in the scene's order.
pub fn shape_requests(scene: &Scene) -> Vec<ShapeRequest> {
    (scene.objects.iter().enumerate())
        .map(|(i, object)| ShapeRequest {
            name: object.name.clone(),
            category: object.category.clone(),
            mesh: object.mesh.clone(),
            scale: object.scale.as_vec3(),
            mass: object.mass.map(|mass| mass as f32),
            convex_parts: object.convex_parts.clone(),
            up: (object.pose.rotation.conjugate() * DVec3::Y).as_vec3(),
            bears: scene.children(i).next().is_some(),
        })
        .collect()
}

/// The world of the scene as it stands: a body for each object, every movable one a unit of its own.
pub fn standing(scene: &Scene, rigs: &[Rig]) -> World {
    let mut roots = Vec::new();
    let mut defs = Vec::with_capacity(rigs.len());
    for (i, (rig, object)) in rigs.iter().zip(&scene.objects).enumerate() {
        let pose = rig.body(&object.pose);
        let unit = if scene.is_static(i) {
            STATIC
        } else {
            roots.push(i as u32);
            roots.len() as u32 - 1
        };
        defs.push(rig.def(unit, pose, pose));
    }
    World::new(&defs, &roots)
}
