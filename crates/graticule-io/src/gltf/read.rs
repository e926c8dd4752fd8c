use std::path::Path;

use glam::{DMat3, DMat4, DVec2, DVec3};
use gltf::json::Root;

use super::UV_SETS;
use super::accessor::Accessors;
use super::buffers::Buffers;
use super::container;
use super::primitive::{self, Arrays, Shapes};
use super::scene::{Instance, instances};
use crate::Format;
use crate::error::{Place, Problem, ReadError};
use crate::obj::LabelRuns;
use crate::read::{Draft, push_polygon};
use crate::stream::ByteStream;
use crate::weld::{Bits, CornerCollector, Numbering, chain_segments};

/// Extensions that change how a surface looks but not where it is.
const HARMLESS_EXTENSIONS: [&str; 6] = [
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "KHR_mesh_quantization",
    "KHR_xmp",
    "EXT_texture_",
];

/// Vertices and corners for each byte of a file. Instances of one mesh may make more of it than
/// it has bytes, but not without bound.
const ELEMENTS_PER_BYTE: u64 = 16;

/// Reads a whole glTF or GLB file; `path` tells where its buffers may be.
pub(crate) fn read(
    stream: ByteStream<'_>,
    path: Option<&Path>,
    draft: &mut Draft,
) -> Result<(), ReadError> {
    let file = stream.read_to_end()?;
    let (json, binary) = if draft.format() == Format::Glb {
        let container = container::split(&file)?;
        (container.json, container.binary)
    } else {
        (file.as_slice(), None)
    };
    let root = parse(json, draft.format())?;
    let buffers = Buffers::fetch(&root, binary, path)?;
    let accessors = Accessors {
        root: &root,
        buffers: &buffers,
    };
    let instances = instances(&root)?;
    check_size(&accessors, &instances, file.len() as u64 + buffers.size())?;
    let mut assembly = Assembly::default();
    for instance in &instances {
        assembly.add_instance(&accessors, instance, draft)?;
    }
    assembly.finish(draft);
    Ok(())
}

fn parse(json: &[u8], format: Format) -> Result<Root, ReadError> {
    let root: Root = gltf::json::deserialize::from_slice(json).map_err(|error| {
        let problem = Problem::Json {
            message: error.to_string(),
        };
        ReadError::malformed(format, Place::Header, problem)
    })?;
    let unsupported = |feature| Err(ReadError::Unsupported { format, feature });
    if !root.asset.version.starts_with("2.") {
        return unsupported(format!("glTF {}", root.asset.version));
    }
    let harmless = |name: &str| {
        HARMLESS_EXTENSIONS
            .iter()
            .any(|known| name.starts_with(known))
    };
    if let Some(name) = root.extensions_required.iter().find(|name| !harmless(name)) {
        return unsupported(format!("the required extension {name}"));
    }
    Ok(root)
}

fn check_size(
    accessors: &Accessors<'_>,
    instances: &[Instance],
    bytes: u64,
) -> Result<(), ReadError> {
    let meshes = &accessors.root.meshes;
    let mut sizes = vec![None; meshes.len()];
    let mut total = 0_u64;
    for instance in instances {
        let size = match sizes[instance.mesh] {
            Some(size) => size,
            None => {
                let mut size = 0_u64;
                for primitive in &meshes[instance.mesh].primitives {
                    size = size.saturating_add(primitive::size(accessors, primitive)?);
                }
                *sizes[instance.mesh].insert(size)
            }
        };
        total = total.saturating_add(size);
    }
    let limit = bytes.saturating_mul(ELEMENTS_PER_BYTE);
    if total > limit {
        let problem = Problem::TooManyInstances { limit };
        return Err(ReadError::malformed(Format::Gltf, Place::Header, problem));
    }
    Ok(())
}

/// The mesh put together from the primitives of all instances.
///
/// glTF splits a vertex wherever an attribute has several values. Vertices of one instance with
/// exactly the same position are joined again, so that a surface with seams is one surface; the
/// values stay with the corners.
#[derive(Default)]
struct Assembly {
    uv_sets: Vec<CornerCollector<DVec2>>,
    normals: CornerCollector<DVec3>,
    colors: Vec<[f32; 4]>,
    /// Whether the same vertex was given two colours.
    color_conflicts: usize,
    objects: LabelRuns,
    materials: LabelRuns,
    points: usize,
    dropped_sets: usize,
    deformed: bool,
}

impl Assembly {
    fn add_instance(
        &mut self,
        accessors: &Accessors<'_>,
        instance: &Instance,
        draft: &mut Draft,
    ) -> Result<(), ReadError> {
        let mesh = &accessors.root.meshes[instance.mesh];
        let polygons = draft.soup.polygons.len();
        self.objects.begin(polygons, instance.name.clone());
        self.deformed |= instance.skinned;
        let first_vertex = draft.soup.positions.len();
        let mut numbering = Numbering::default();
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let place = Place::Primitive {
                mesh: instance.mesh,
                primitive: number,
            };
            let Some(arrays) = primitive::read(accessors, primitive, &place)? else {
                continue;
            };
            self.deformed |= primitive.targets.is_some();
            let material = primitive.material.map(|index| index.value());
            let name =
                material.map_or_else(String::new, |index| material_name(accessors.root, index));
            self.materials.begin(draft.soup.polygons.len(), name);
            let vertices = self.add_vertices(
                &arrays,
                instance.transform,
                first_vertex,
                &mut numbering,
                draft,
            )?;
            self.add_shapes(&arrays, &vertices, instance.transform, draft)?;
        }
        Ok(())
    }

    /// Adds the vertices of a primitive; returns their numbers in the whole.
    fn add_vertices(
        &mut self,
        arrays: &Arrays,
        transform: DMat4,
        first: usize,
        numbering: &mut Numbering<[u64; 3]>,
        draft: &mut Draft,
    ) -> Result<Vec<u32>, ReadError> {
        let mut numbers = Vec::with_capacity(arrays.positions.len());
        for (index, &position) in arrays.positions.iter().enumerate() {
            let position = transform.transform_point3(DVec3::from_array(position));
            let (number, new) = numbering.number(position.bits());
            let vertex = first + number as usize;
            if vertex >= u32::MAX as usize - 1 {
                return Err(ReadError::TooLarge {
                    elements: "vertices",
                    limit: u64::from(u32::MAX) - 1,
                });
            }
            if new {
                draft.soup.positions.push(position);
            }
            if let Some(colors) = &arrays.colors {
                self.color(vertex, colors[index].map(|part| part as f32), new);
            }
            numbers.push(vertex as u32);
        }
        Ok(numbers)
    }

    fn color(&mut self, vertex: usize, color: [f32; 4], new: bool) {
        if new || vertex >= self.colors.len() {
            self.colors.resize(vertex, [1.0; 4]);
            self.colors.push(color);
        } else if self.colors[vertex] != color {
            self.color_conflicts += 1;
        }
    }

    fn add_shapes(
        &mut self,
        arrays: &Arrays,
        vertices: &[u32],
        transform: DMat4,
        draft: &mut Draft,
    ) -> Result<(), ReadError> {
        let triangles = match &arrays.shapes {
            Shapes::Triangles(triangles) => triangles,
            Shapes::Segments(segments) => {
                let segments = segments
                    .iter()
                    .map(|ends| ends.map(|end| vertices[end as usize]));
                draft.soup.polylines.extend(chain_segments(segments));
                return Ok(());
            }
            Shapes::Points => {
                self.points += arrays.positions.len();
                return Ok(());
            }
        };
        let linear = DMat3::from_mat4(transform);
        // A mirroring transform turns the faces round (glTF 2.0 §3.7.4).
        let mirrored = linear.determinant() < 0.0;
        let corner_start = draft.soup.polygons.corner_count();
        self.prepare_sets(arrays, corner_start);
        if arrays.normals.is_some() {
            self.normals.skip_to(corner_start);
        }
        let to_normal = cofactors(linear);
        for &[a, b, c] in triangles {
            let corners = if mirrored { [a, c, b] } else { [a, b, c] };
            let polygon = corners.map(|corner| vertices[corner as usize]);
            push_polygon(&mut draft.soup.polygons, &polygon)?;
            for (corner, vertex) in corners.into_iter().zip(polygon) {
                for (set, uvs) in &arrays.uv_sets {
                    if let Some(collector) = self.uv_sets.get_mut(*set) {
                        let [u, v] = uvs[corner as usize];
                        // glTF counts v downward from the top of the image.
                        collector.push(vertex, DVec2::new(u, 1.0 - v));
                    }
                }
                if let Some(normals) = &arrays.normals {
                    let normal = to_normal * DVec3::from_array(normals[corner as usize]);
                    self.normals.push(
                        vertex,
                        if transform == DMat4::IDENTITY {
                            normal
                        } else {
                            normal.normalize_or_zero()
                        },
                    );
                }
            }
        }
        Ok(())
    }

    fn prepare_sets(&mut self, arrays: &Arrays, corner_start: usize) {
        for &(set, _) in &arrays.uv_sets {
            if set >= UV_SETS {
                self.dropped_sets += 1;
                continue;
            }
            while self.uv_sets.len() <= set {
                self.uv_sets.push(CornerCollector::default());
            }
            self.uv_sets[set].skip_to(corner_start);
        }
    }

    fn finish(mut self, draft: &mut Draft) {
        self.warn(draft);
        let corners = draft.soup.polygons.corner_count();
        let polygons = draft.soup.polygons.len();
        let attributes = &mut draft.soup.attributes;
        let sets = self.uv_sets.into_iter().enumerate();
        attributes.uv_sets = sets
            .filter_map(|(number, set)| {
                let mut set = set.finish(corners)?;
                set.name = format!("TEXCOORD_{number}");
                Some(set)
            })
            .collect();
        attributes.normals = self.normals.finish(corners);
        attributes.objects = self.objects.finish(polygons);
        attributes.materials = self.materials.finish(polygons);
        if !self.colors.is_empty() {
            self.colors.resize(draft.soup.positions.len(), [1.0; 4]);
            attributes.vertex_colors = Some(self.colors);
        }
    }

    fn warn(&self, draft: &mut Draft) {
        if self.deformed {
            draft.warn(
                "deformation-ignored",
                "skins and morph targets were ignored",
            );
        }
        if self.color_conflicts > 0 {
            let count = self.color_conflicts;
            draft.warn(
                "color-conflicts",
                format!(
                    "{count} vertices have several colours at one position: the first was taken"
                ),
            );
        }
        if self.points > 0 {
            draft.warn(
                "points-ignored",
                format!("{} single points were ignored", self.points),
            );
        }
        if self.dropped_sets > 0 {
            draft.warn(
                "uv-sets-ignored",
                format!("texture coordinate sets from number {UV_SETS} on were ignored"),
            );
        }
    }
}

fn material_name(root: &Root, index: usize) -> String {
    let named = root
        .materials
        .get(index)
        .and_then(|material| material.name.clone());
    let name = named.filter(|name| !name.is_empty());
    name.unwrap_or_else(|| format!("material {index}"))
}

/// The matrix that turns normals as `linear` turns surfaces, up to a positive factor; defined for
/// singular matrices too.
fn cofactors(linear: DMat3) -> DMat3 {
    let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
    let matrix = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    if linear.determinant() < 0.0 {
        -matrix
    } else {
        matrix
    }
}
