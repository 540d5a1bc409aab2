//! PLY, text and binary, by the `ply-rs-bw` crate, which reads numbers of any type and skips what nobody asks for.
//! Normals and colours of vertices are its look.

use super::{Source, add_strip, to_linear};
use crate::shape::{Corner, Look, Mesh, MeshError, Skin};
use glam::{DVec3, Vec3};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

pub(super) fn read(source: &Source<'_>, look: Option<&mut Look>) -> Result<Mesh, MeshError> {
    let mut reader = Reader::new(source.bytes.as_slice());
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(|e| source.damaged(e))?;
    let mut mesh = Mesh::default();
    let mut corners = Vec::new();
    let mut tinted = false;
    for element in header.elements.values() {
        if !holds_bytes(source, &header, element, reader.get_ref().len())? {
            continue;
        }
        match element.name.as_str() {
            "vertex" if !["x", "y", "z"].into_iter().all(|axis| element.properties.contains_key(axis)) => {
                return Err(source.damaged("its vertices have no x, y and z"));
            }
            "vertex" => {
                let rows = rows::<Vertex>(source, &mut reader, &header, element)?;
                mesh.vertices = rows.iter().map(|row| row.position.as_vec3()).collect();
                if look.is_some() {
                    tinted = ["red", "green", "blue"].into_iter().all(|name| element.properties.contains_key(name));
                    corners = rows.iter().map(Vertex::corner).collect();
                }
            }
            "face" => {
                for Corners(corners) in rows(source, &mut reader, &header, element)? {
                    mesh.add_polygon(&unsigned(source, &corners)?);
                }
            }
            "tristrips" => {
                for Corners(corners) in rows(source, &mut reader, &header, element)? {
                    // −1 starts a new strip.
                    for strip in corners.split(|&corner| corner == -1) {
                        add_strip(&mut mesh.triangles, &unsigned(source, strip)?);
                    }
                }
            }
            _ => drop(rows::<Skipped>(source, &mut reader, &header, element)?),
        }
    }
    if let Some(look) = look {
        look.skins.push(Skin { tinted, ..Skin::default() });
        for triangle in &mesh.triangles {
            // A corner out of range is refused later.
            look.push(triangle.map(|i| corners.get(i as usize).copied().unwrap_or_default()), 0);
        }
    }
    Ok(mesh)
}

fn rows<E: PropertyAccess>(
    source: &Source<'_>,
    reader: &mut Reader<&[u8]>,
    header: &Header,
    element: &ElementDef,
) -> Result<Vec<E>, MeshError> {
    Parser::new().read_payload_for_element(reader, element, header).map_err(|e| source.damaged(e))
}

/// False for an element without content. An error for one that cannot fit into the bytes that are left: the parser
/// would go through the announced count, however large, even where a row takes no bytes at all.
fn holds_bytes(source: &Source<'_>, header: &Header, element: &ElementDef, left: usize) -> Result<bool, MeshError> {
    let row: usize = match header.encoding {
        Encoding::Ascii => 1,
        _ => element.properties.values().map(|property| smallest(&property.data_type)).sum(),
    };
    if row.saturating_mul(element.count) <= left {
        return Ok(row * element.count > 0);
    }
    let problem = format!("it breaks off: {} rows of \"{}\" are announced", element.count, element.name);
    Err(source.damaged(problem))
}

/// Fewest bytes that a property takes: an empty list is its count only.
fn smallest(property: &PropertyType) -> usize {
    match property {
        PropertyType::Scalar(kind) | PropertyType::List(kind, _) => match kind {
            ScalarType::Char | ScalarType::UChar => 1,
            ScalarType::Short | ScalarType::UShort => 2,
            ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
            ScalarType::Double => 8,
        },
    }
}

fn unsigned(source: &Source<'_>, corners: &[i64]) -> Result<Vec<u32>, MeshError> {
    let corners = corners.iter().map(|&corner| u32::try_from(corner)).collect::<Result<_, _>>();
    corners.map_err(|_| source.damaged("a corner of a face is no vertex number"))
}

/// A row of which nothing is kept.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

/// A vertex with what is seen of it. Colours are as in the file: whole numbers up to 255, others up to 1.
struct Vertex {
    position: DVec3,
    normal: DVec3,
    color: DVec3,
}

impl Vertex {
    fn corner(&self) -> Corner {
        let normal = self.normal.as_vec3().try_normalize().unwrap_or(Vec3::ZERO);
        let color = self.color.as_vec3();
        let color = if color.is_finite() { to_linear(color) } else { Vec3::ONE };
        Corner { normal, color: color.extend(1.0), ..Corner::default() }
    }
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self { position: DVec3::NAN, normal: DVec3::ZERO, color: DVec3::ONE }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let (value, largest) = match property {
            Property::Char(x) => (x.into(), 255.0),
            Property::UChar(x) => (x.into(), 255.0),
            Property::Short(x) => (x.into(), 255.0),
            Property::UShort(x) => (x.into(), 65535.0),
            Property::Int(x) => (x.into(), 255.0),
            Property::UInt(x) => (x.into(), 255.0),
            Property::Float(x) => (x.into(), 1.0),
            Property::Double(x) => (x, 1.0),
            _ => return PropertyAccessResult::Ignored,
        };
        match name {
            "x" => self.position.x = value,
            "y" => self.position.y = value,
            "z" => self.position.z = value,
            "nx" => self.normal.x = value,
            "ny" => self.normal.y = value,
            "nz" => self.normal.z = value,
            "red" => self.color.x = value / largest,
            "green" => self.color.y = value / largest,
            "blue" => self.color.z = value / largest,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// The corners of a polygon or strip.
struct Corners(Vec<i64>);

impl PropertyAccess for Corners {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        self.0 = match property {
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}
