//! GLB and glTF: the triangles of every node of the default scene, its transform applied.
//!
//! Skins and morph targets are ignored, materials and images too unless asked for (`gltf_look`). Geometry that only an
//! extension holds is an error.

use super::accessor::Buffers;
use super::gltf_look::LookReader;
use super::polygon::fan;
use super::{MAX_ELEMENTS, Source, add_strip};
use crate::shape::{Look, Mesh, MeshError};
use ::gltf::binary::Glb;
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::scene::Node;
use ::gltf::json::validation::Checked;
use ::gltf::json::{Index, Root};
use glam::{DMat4, DQuat, DVec3, Quat, Vec3};

/// Length of the header of a GLB.
const HEADER: usize = 12;
/// Required extensions that hide the geometry from whoever does not know them.
const UNREADABLE: [&str; 4] =
    ["KHR_draco_mesh_compression", "KHR_meshopt_compression", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing"];

pub(super) fn read_binary(source: &Source<'_>, look: Option<&mut Look>) -> Result<Mesh, MeshError> {
    // The crate subtracts the header's length from the announced one without a look.
    let length = source.bytes.get(8..HEADER).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let whole = length.filter(|&length| length >= HEADER).and_then(|length| source.bytes.get(..length));
    let whole = whole.ok_or_else(|| {
        let announced = length.map_or_else(|| "a header".to_owned(), |length| format!("{length} bytes"));
        source.damaged(format!("it breaks off: {announced} announced, {} bytes there", source.bytes.len()))
    })?;
    let glb = Glb::from_slice(whole).map_err(|e| source.damaged(format!("it is not a GLB: {e}")))?;
    // Some writers pad the text with zeros instead of spaces.
    let end = glb.json.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    read_document(source, &glb.json[..end], glb.bin.as_deref(), look)
}

pub(super) fn read_text(source: &Source<'_>, look: Option<&mut Look>) -> Result<Mesh, MeshError> {
    read_document(source, &source.bytes, None, look)
}

fn read_document(
    source: &Source<'_>,
    json: &[u8],
    chunk: Option<&[u8]>,
    look: Option<&mut Look>,
) -> Result<Mesh, MeshError> {
    let root = Root::from_slice(json).map_err(|e| source.damaged(format!("its JSON is not that of glTF 2: {e}")))?;
    if let Some(extension) = root.extensions_required.iter().find(|name| UNREADABLE.contains(&name.as_str())) {
        return Err(source.error(format!("it needs {extension}"), "export the mesh without compression or instancing"));
    }
    let buffers = Buffers::new(source, &root, chunk);
    let look = look.map(LookReader::new);
    let mut reader = Reader { source, root: &root, buffers, mesh: Mesh::default(), look };
    reader.read_scene()?;
    Ok(reader.mesh)
}

struct Reader<'a> {
    source: &'a Source<'a>,
    root: &'a Root,
    buffers: Buffers<'a>,
    mesh: Mesh,
    look: Option<LookReader<'a>>,
}

impl Reader<'_> {
    fn read_scene(&mut self) -> Result<(), MeshError> {
        let mut visited = vec![false; self.root.nodes.len()];
        let mut stack: Vec<(Index<Node>, DMat4)> = Vec::new();
        // Last in, first out: the order of the file needs the reverse.
        stack.extend(self.top_nodes().into_iter().rev().map(|node| (node, DMat4::IDENTITY)));
        while let Some((index, parent)) = stack.pop() {
            let node = self.root.get(index).ok_or_else(|| self.source.damaged("a node is missing"))?;
            if std::mem::replace(&mut visited[index.value()], true) {
                return Err(self.source.damaged(format!("node {} has several parents", index.value())));
            }
            let transform = parent * local_transform(node);
            if let Some(mesh) = node.mesh {
                let mesh = self.root.get(mesh).ok_or_else(|| self.source.damaged("a mesh is missing"))?;
                for primitive in &mesh.primitives {
                    self.read_primitive(primitive, transform)?;
                }
            }
            stack.extend(node.children.iter().flatten().rev().map(|&child| (child, transform)));
        }
        Ok(())
    }

    /// The nodes of the default scene; of the first one where none is named; without scenes, all that are nobody's
    /// child.
    fn top_nodes(&self) -> Vec<Index<Node>> {
        let scene = self.root.scene.map_or(self.root.scenes.first(), |scene| self.root.get(scene));
        if let Some(scene) = scene {
            return scene.nodes.clone();
        }
        let mut is_child = vec![false; self.root.nodes.len()];
        for child in self.root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
            if let Some(is_child) = is_child.get_mut(child.value()) {
                *is_child = true;
            }
        }
        let tops = is_child.iter().enumerate().filter(|&(_, is_child)| !is_child);
        tops.map(|(i, _)| Index::new(i as u32)).collect()
    }

    fn read_primitive(&mut self, primitive: &Primitive, transform: DMat4) -> Result<(), MeshError> {
        let Some(&positions) = primitive.attributes.get(&Checked::Valid(Semantic::Positions)) else { return Ok(()) };
        let Checked::Valid(mode) = primitive.mode else {
            return Err(self.source.damaged("a primitive's mode is not known"));
        };
        if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
            return Ok(());
        }
        let positions = self.buffers.positions(positions)?;
        let corners = match primitive.indices {
            Some(indices) => self.buffers.indices(indices)?,
            None => (0..positions.len() as u32).collect(),
        };
        let (vertices, triangles) = (&mut self.mesh.vertices, &mut self.mesh.triangles);
        let (first_vertex, first_triangle) = (vertices.len() as u32, triangles.len());
        if vertices.len() + positions.len() > MAX_ELEMENTS || triangles.len() + corners.len() / 3 > MAX_ELEMENTS {
            return Err(self.source.too_large());
        }
        if let Some(corner) = corners.iter().find(|&&corner| corner as usize >= positions.len()) {
            let problem = format!("a face names vertex {corner}, and there are only {}", positions.len());
            return Err(self.source.damaged(problem));
        }
        match mode {
            Mode::TriangleStrip => add_strip(triangles, &corners),
            Mode::TriangleFan => triangles.extend(fan(corners.len()).map(|triangle| triangle.map(|i| corners[i]))),
            _ => triangles.extend_from_slice(corners.as_chunks().0),
        }
        // A mirrored mesh would be inside out.
        let mirrored = transform.determinant() < 0.0;
        for triangle in &mut triangles[first_triangle..] {
            *triangle = triangle.map(|corner| corner + first_vertex);
            if mirrored {
                triangle.swap(1, 2);
            }
        }
        vertices.extend(positions.iter().map(|p| transform.transform_point3(p.as_dvec3()).as_vec3()));
        if let Some(look) = &mut self.look {
            let corners =
                triangles[first_triangle..].iter().map(|triangle| triangle.map(|corner| corner - first_vertex));
            look.read_primitive(self.root, &mut self.buffers, primitive, transform, corners);
        }
        Ok(())
    }
}

fn local_transform(node: &Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let rotation = node.rotation.map_or(Quat::IDENTITY, |q| Quat::from_array(q.0)).as_dquat();
    DMat4::from_scale_rotation_translation(
        node.scale.map_or(DVec3::ONE, |s| Vec3::from(s).as_dvec3()),
        // A quaternion of zeros gives NaN here, and so an error later.
        DQuat::normalize(rotation),
        node.translation.map_or(DVec3::ZERO, |t| Vec3::from(t).as_dvec3()),
    )
}
