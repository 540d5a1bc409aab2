//! Whatever the bytes, it is read or refused; and what was read survives the way out and back.

use crate::fixture::*;
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use rest3d_gpu::import;
use serde_json::{Value, json};

/// Every place in a document, as JSON pointers.
fn pointers(value: &Value, at: &str, all: &mut Vec<String>) {
    all.push(at.to_owned());
    match value {
        Value::Array(list) => list.iter().enumerate().for_each(|(i, v)| pointers(v, &format!("{at}/{i}"), all)),
        Value::Object(map) => map.iter().for_each(|(key, v)| pointers(v, &format!("{at}/{key}"), all)),
        _ => {}
    }
}

fn any_value() -> impl Strategy<Value = Value> {
    prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
        prop::sample::select(vec![
            "",
            "mug",
            "desk",
            "ground",
            "floor-wall",
            "hang",
            "meshes/mug_1.obj",
            "..",
            "\0",
            "Z"
        ])
        .prop_map(Value::from),
        prop::collection::vec(-2.0..2.0, 0..5).prop_map(Value::from),
        Just(json!({})),
        Just(json!([{}])),
    ]
}

/// Either an error in the uniform shape, or a scene that is written and read again.
fn survives(folder: &Folder, text: &[u8]) {
    match folder.read_text(text) {
        Err(error) => assert!(error.to_string().starts_with(&format!("{}:", error.file.display()))),
        Ok(scene) => {
            assert_eq!(scene.post_order().len(), scene.objects.len());
            let written = scene.to_json(folder.0.path());
            assert_eq!(folder.read_text(written).unwrap().objects, scene.objects);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn poses_survive_the_way_out_and_back(
        up in prop::sample::select(vec!["Y", "Z"]),
        unit in 1e-3..1e3f64,
        ground in -10.0..10.0f64,
        place in prop::array::uniform3(-10.0..10.0f64),
        quaternion in prop::array::uniform4(-1.0..1.0f64),
        shift in prop::array::uniform3(-1.0..1.0f64),
        turn in prop::array::uniform3(-1.0..1.0f64),
    ) {
        prop_assume!(DQuat::from_array(quaternion).length() > 0.1);
        let mut document = full();
        document["frame"] = json!({"up": up, "meters_per_unit": unit});
        document["room"] = json!({"ground": ground});
        document["objects"][0]["position"] = json!(place);
        document["objects"][0]["rotation_xyzw"] = json!(quaternion);
        let folder = Folder::new();
        let mut scene = folder.read(&document).unwrap();
        let unmoved: Value = serde_json::from_str(&scene.to_json(folder.0.path())).unwrap();
        prop_assert_eq!(&unmoved, &document);
        let pose = &mut scene.objects[0].pose;
        pose.translation += DVec3::from(shift);
        pose.rotation = (DQuat::from_scaled_axis(turn.into()) * pose.rotation).normalize();
        let again = folder.read_text(scene.to_json(folder.0.path())).unwrap();
        // Rounding of a handful of operations on numbers of this size.
        let tolerance = 1e-12 * (unit * 10.0).max(1.0);
        prop_assert!(again.objects[0].pose.translation.abs_diff_eq(scene.objects[0].pose.translation, tolerance));
        prop_assert!(again.objects[0].pose.rotation.abs_diff_eq(scene.objects[0].pose.rotation, 1e-12));
    }

    #[test]
    fn changed_values_are_survived(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any_value()), 1..4),
    ) {
        let mut document = full();
        for (at, value) in changes {
            let mut all = Vec::new();
            pointers(&document, "", &mut all);
            *document.pointer_mut(&all[at.index(all.len())]).unwrap() = value;
        }
        survives(&Folder::new(), document.to_string().as_bytes());
    }

    #[test]
    fn changed_bytes_are_survived(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        length in any::<prop::sample::Index>(),
        cut in any::<bool>(),
    ) {
        let mut bytes = full().to_string().into_bytes();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if cut {
            bytes.truncate(length.index(bytes.len()));
        }
        survives(&Folder::new(), &bytes);
    }

    #[test]
    fn changed_trees_are_survived(
        at in any::<prop::sample::Index>(),
        value in any_value(),
    ) {
        let mut tree = json!({"roots": ["floor"], "nodes": ["desk", {"name": "mug", "movable": true}], "edges": [
            {"child": "desk", "parent": "floor", "relation": "on", "type": "movable"},
            {"child": "mug", "parent": "desk", "relation": "on", "type": "movable"}
        ]});
        let mut all = Vec::new();
        pointers(&tree, "", &mut all);
        *tree.pointer_mut(&all[at.index(all.len())]).unwrap() = value;
        let folder = stage2(&tree, &["desk", "mug"]);
        if let Err(error) = import::read(folder.path()) {
            prop_assert!(error.to_string().contains("scene_tree.json"));
        }
    }
}
