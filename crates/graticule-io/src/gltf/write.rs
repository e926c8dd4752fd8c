use std::collections::BTreeMap;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use graticule::mesh::{CornerAttribute, NO_VALUE, PolygonLabels, PolygonSoup};
use serde_json::{Value, json};

use super::UV_SETS;
use super::container::{BINARY_CHUNK, JSON_CHUNK};
use crate::Format;
use crate::weld::Numbering;
use crate::write::{Losses, Sink, WriteError, triangles};

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const LINES: u32 = 1;

/// Writes a whole GLB file.
pub(crate) fn write_glb(
    sink: &mut Sink<'_>,
    soup: &PolygonSoup,
    losses: &mut Losses,
) -> Result<(), WriteError> {
    let document = Document::of(soup, losses);
    let mut json = document.json(None).to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut binary = document.binary;
    binary.resize(binary.len().next_multiple_of(4), 0);
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let Ok(length) = u32::try_from(length) else {
        return Err(WriteError::UnsupportedByFormat {
            format: Format::Glb,
            what: format!("{length} bytes"),
        });
    };
    sink.bytes(b"glTF")?;
    for word in [2, length, json.len() as u32, JSON_CHUNK] {
        sink.bytes(&word.to_le_bytes())?;
    }
    sink.bytes(&json)?;
    for word in [binary.len() as u32, BINARY_CHUNK] {
        sink.bytes(&word.to_le_bytes())?;
    }
    sink.bytes(&binary)?;
    Ok(())
}

/// Writes a whole glTF file with its buffer inside.
pub(crate) fn write_gltf(
    sink: &mut Sink<'_>,
    soup: &PolygonSoup,
    losses: &mut Losses,
) -> Result<(), WriteError> {
    let document = Document::of(soup, losses);
    let data = STANDARD.encode(&document.binary);
    let uri = format!("data:application/octet-stream;base64,{data}");
    sink.text(&document.json(Some(&uri)).to_string())?;
    sink.line_end()?;
    Ok(())
}

/// A triangle by its three corner numbers, with what decides on its primitive.
struct Triangle {
    corners: [u32; 3],
    material: u32,
    /// Which attributes all three corners have: a bit for each column.
    columns: u32,
}

/// For each corner the number of its value of one attribute.
struct Column<'a> {
    name: String,
    indices: &'a [u32],
    count: usize,
    /// The numbers of a value in the file.
    value: Box<dyn Fn(usize) -> Vec<f32> + 'a>,
    width: usize,
}

impl Column<'_> {
    fn index(&self, corner: u32) -> u32 {
        let index = self
            .indices
            .get(corner as usize)
            .copied()
            .unwrap_or(NO_VALUE);
        if (index as usize) < self.count {
            index
        } else {
            NO_VALUE
        }
    }
}

fn column<'a, T>(
    name: String,
    set: &'a CornerAttribute<T>,
    width: usize,
    value: impl Fn(&T) -> Vec<f32> + 'a,
) -> Column<'a> {
    Column {
        name,
        indices: &set.corner_values,
        count: set.values.len(),
        value: Box::new(move |index| value(&set.values[index])),
        width,
    }
}

fn columns(soup: &PolygonSoup) -> Vec<Column<'_>> {
    let sets = soup.attributes.uv_sets.iter().take(UV_SETS).enumerate();
    let mut columns: Vec<_> = sets
        .map(|(number, set)| {
            // glTF counts v downward from the top of the image.
            let flipped = |uv: &glam::DVec2| vec![uv.x as f32, (1.0 - uv.y) as f32];
            column(format!("TEXCOORD_{number}"), set, 2, flipped)
        })
        .collect();
    columns.extend(soup.attributes.normals.as_ref().map(|set| {
        let plain = |normal: &glam::DVec3| normal.to_array().map(|part| part as f32).to_vec();
        column("NORMAL".to_owned(), set, 3, plain)
    }));
    columns
}

/// A glTF document under construction.
struct Document {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    materials: Vec<Value>,
}

impl Document {
    fn of(soup: &PolygonSoup, losses: &mut Losses) -> Self {
        losses.lose_groups(&soup.attributes);
        losses.lose_uv_sets(&soup.attributes, UV_SETS);
        losses.lose_shape(soup);
        let mut document = Self {
            binary: Vec::new(),
            views: Vec::new(),
            accessors: Vec::new(),
            meshes: Vec::new(),
            nodes: Vec::new(),
            materials: material_names(soup)
                .iter()
                .map(|name| json!({ "name": name }))
                .collect(),
        };
        let used = used_vertices(soup);
        losses.lose_unused_vertices(soup, &used);
        let columns = columns(soup);
        for (name, triangles) in objects(soup, &columns, losses) {
            document.add_object(name, &triangles, soup, &columns);
        }
        document
    }

    /// Adds a node with a mesh: one vertex for each combination of a vertex and its values, in
    /// the order of the vertices, shared by all primitives.
    fn add_object(
        &mut self,
        name: Option<&str>,
        triangles: &[Triangle],
        soup: &PolygonSoup,
        columns: &[Column<'_>],
    ) {
        let split = Split::of(triangles, soup, columns);
        let attributes = self.add_attributes(&split, soup, columns);
        let mut primitives = Vec::new();
        for ((material, mask), indices) in &split.primitives {
            let present = (0..columns.len()).filter(|k| mask & (1 << k) != 0);
            let mut names: Vec<&str> = vec!["POSITION", "COLOR_0"];
            names.extend(present.map(|k| columns[k].name.as_str()));
            let mut primitive = json!({
                "attributes": select(&attributes, &names),
                "indices": self.add_indices(indices),
            });
            if *material != NO_VALUE {
                primitive["material"] = json!(material);
            }
            primitives.push(primitive);
        }
        let segments: Vec<u32> = soup
            .polylines
            .iter()
            .flat_map(|line| line.windows(2).flatten())
            .map(|&vertex| split.first_of_vertex[vertex as usize])
            .collect();
        if !segments.is_empty() {
            primitives.push(json!({
                "attributes": select(&attributes, &["POSITION"]),
                "indices": self.add_indices(&segments),
                "mode": LINES,
            }));
        }
        let mut node = json!({ "mesh": self.meshes.len() });
        if let Some(name) = name {
            node["name"] = json!(name);
        }
        self.nodes.push(node);
        self.meshes.push(json!({ "primitives": primitives }));
    }

    fn add_attributes(
        &mut self,
        split: &Split,
        soup: &PolygonSoup,
        columns: &[Column<'_>],
    ) -> BTreeMap<String, usize> {
        let mut attributes = BTreeMap::new();
        let position = |item: &Item| {
            let position = soup.positions[item.vertex as usize].to_array();
            position.map(|part| part as f32).to_vec()
        };
        let accessor = self.add_floats(split.items.iter().map(position), 3);
        self.bound_positions(accessor, split, soup);
        attributes.insert("POSITION".to_owned(), accessor);
        if let Some(colors) = &soup.attributes.vertex_colors {
            let color = |item: &Item| {
                colors
                    .get(item.vertex as usize)
                    .map_or(vec![1.0; 4], |color| color.to_vec())
            };
            let accessor = self.add_floats(split.items.iter().map(color), 4);
            attributes.insert("COLOR_0".to_owned(), accessor);
        }
        for (number, column) in columns.iter().enumerate() {
            let values = split.items.iter().map(|item| {
                let index = item.values.get(number).copied().unwrap_or(NO_VALUE);
                if index == NO_VALUE {
                    vec![0.0; column.width]
                } else {
                    (column.value)(index as usize)
                }
            });
            let accessor = self.add_floats(values, column.width);
            attributes.insert(column.name.clone(), accessor);
        }
        attributes
    }

    /// The format asks for the extent of positions.
    fn bound_positions(&mut self, accessor: usize, split: &Split, soup: &PolygonSoup) {
        let mut low = [f32::INFINITY; 3];
        let mut high = [f32::NEG_INFINITY; 3];
        for item in &split.items {
            let position = soup.positions[item.vertex as usize].to_array();
            for axis in 0..3 {
                low[axis] = low[axis].min(position[axis] as f32);
                high[axis] = high[axis].max(position[axis] as f32);
            }
        }
        if !split.items.is_empty() {
            self.accessors[accessor]["min"] = json!(low);
            self.accessors[accessor]["max"] = json!(high);
        }
    }

    fn add_floats(&mut self, values: impl Iterator<Item = Vec<f32>>, width: usize) -> usize {
        let start = self.binary.len();
        self.binary
            .extend(values.flatten().flat_map(f32::to_le_bytes));
        let kind = ["VEC2", "VEC3", "VEC4"][width - 2];
        self.add_accessor(start, 4 * width, (FLOAT, kind, ARRAY_BUFFER))
    }

    fn add_indices(&mut self, indices: &[u32]) -> usize {
        let start = self.binary.len();
        self.binary
            .extend(indices.iter().flat_map(|index| index.to_le_bytes()));
        self.add_accessor(start, 4, (UNSIGNED_INT, "SCALAR", ELEMENT_ARRAY_BUFFER))
    }

    fn add_accessor(
        &mut self,
        start: usize,
        size: usize,
        (component, kind, target): (u32, &str, u32),
    ) -> usize {
        let length = self.binary.len() - start;
        self.views.push(json!({
            "buffer": 0, "byteOffset": start, "byteLength": length, "target": target,
        }));
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1, "componentType": component, "count": length / size, "type": kind,
        }));
        self.accessors.len() - 1
    }

    fn json(&self, uri: Option<&str>) -> Value {
        let mut buffer = json!({ "byteLength": self.binary.len() });
        if let Some(uri) = uri {
            buffer["uri"] = json!(uri);
        }
        let nodes: Vec<usize> = (0..self.nodes.len()).collect();
        let mut root = json!({
            "asset": { "version": "2.0", "generator": "Graticule" },
            "scene": 0,
            "scenes": [{ "nodes": nodes }],
            "nodes": self.nodes,
            "meshes": self.meshes,
        });
        // An empty list is not allowed.
        let lists = [
            ("materials", &self.materials),
            ("accessors", &self.accessors),
            ("bufferViews", &self.views),
        ];
        for (name, list) in lists {
            if !list.is_empty() {
                root[name] = json!(list);
            }
        }
        root["buffers"] = json!([buffer]);
        root
    }
}

fn select(attributes: &BTreeMap<String, usize>, names: &[&str]) -> Value {
    let chosen = names.iter().filter_map(|&name| {
        let accessor = attributes.get(name)?;
        Some((name.to_owned(), json!(accessor)))
    });
    Value::Object(chosen.collect())
}

fn material_names(soup: &PolygonSoup) -> &[String] {
    let materials = soup.attributes.materials.as_ref();
    materials.map_or(&[], |materials| &materials.names)
}

fn used_vertices(soup: &PolygonSoup) -> Vec<bool> {
    let mut used = vec![false; soup.positions.len()];
    let lines = soup
        .polylines
        .iter()
        .filter(|line| line.len() > 1)
        .flatten();
    for &vertex in soup.polygons.corner_vertices().iter().chain(lines) {
        used[vertex as usize] = true;
    }
    used
}

/// A vertex of the file: a vertex of the mesh with one value of each attribute.
struct Item {
    vertex: u32,
    values: Vec<u32>,
}

/// The vertices of one object, split where attributes have several values.
struct Split {
    items: Vec<Item>,
    /// For each vertex of the mesh its first item.
    first_of_vertex: Vec<u32>,
    /// Material and attributes with the indices of their triangles, in the order of their first
    /// appearance.
    primitives: Vec<((u32, u32), Vec<u32>)>,
}

impl Split {
    fn of(triangles: &[Triangle], soup: &PolygonSoup, columns: &[Column<'_>]) -> Self {
        let corners: Vec<u32> = triangles
            .iter()
            .flat_map(|triangle| triangle.corners)
            .collect();
        let vertices = soup.polygons.corner_vertices();
        let mut numbers: Vec<u32> = corners
            .iter()
            .map(|&corner| vertices[corner as usize])
            .collect();
        for column in columns {
            let mut numbering = Numbering::<(u32, u32)>::default();
            for (number, &corner) in numbers.iter_mut().zip(&corners) {
                *number = numbering.number((*number, column.index(corner))).0;
            }
        }
        // One corner for each combination, then in the order of the vertices.
        let mut numbering = Numbering::<u32>::default();
        let mut items: Vec<Item> = Vec::new();
        for (number, &corner) in numbers.iter_mut().zip(&corners) {
            let (item, new) = numbering.number(*number);
            *number = item;
            if new {
                items.push(Item {
                    vertex: vertices[corner as usize],
                    values: columns.iter().map(|column| column.index(corner)).collect(),
                });
            }
        }
        let lines = soup
            .polylines
            .iter()
            .filter(|line| line.len() > 1)
            .flatten();
        Self::sorted(
            items,
            &numbers,
            triangles,
            lines.copied(),
            soup.positions.len(),
        )
    }

    fn sorted(
        mut items: Vec<Item>,
        numbers: &[u32],
        triangles: &[Triangle],
        lines: impl Iterator<Item = u32>,
        vertices: usize,
    ) -> Self {
        let mut has_item = vec![false; vertices];
        for item in &items {
            has_item[item.vertex as usize] = true;
        }
        for vertex in lines {
            if !std::mem::replace(&mut has_item[vertex as usize], true) {
                let values = Vec::new();
                items.push(Item { vertex, values });
            }
        }
        let mut order: Vec<u32> = (0..items.len() as u32).collect();
        order.sort_by_key(|&item| items[item as usize].vertex);
        let mut rank = vec![0; items.len()];
        let mut first_of_vertex = vec![NO_VALUE; vertices];
        for (position, &item) in (0..).zip(&order) {
            rank[item as usize] = position;
            let first = &mut first_of_vertex[items[item as usize].vertex as usize];
            *first = (*first).min(position);
        }
        let mut kinds = Numbering::<(u32, u32)>::default();
        let mut primitives: Vec<((u32, u32), Vec<u32>)> = Vec::new();
        for (triangle, corners) in triangles.iter().zip(numbers.chunks_exact(3)) {
            let kind = (triangle.material, triangle.columns);
            let (number, new) = kinds.number(kind);
            if new {
                primitives.push((kind, Vec::new()));
            }
            let (_, indices) = &mut primitives[number as usize];
            indices.extend(corners.iter().map(|&item| rank[item as usize]));
        }
        items.sort_by_key(|item| item.vertex);
        Self {
            items,
            first_of_vertex,
            primitives,
        }
    }
}

/// The triangles of each object, in the order of the first appearance of objects.
fn objects<'a>(
    soup: &'a PolygonSoup,
    columns: &[Column<'_>],
    losses: &mut Losses,
) -> Vec<(Option<&'a str>, Vec<Triangle>)> {
    let labels = soup.attributes.objects.as_ref().filter(|labels| {
        let apart = soup.polylines.is_empty() && objects_are_apart(soup, labels);
        losses.lose("objects that share vertices or have polylines", !apart);
        apart
    });
    let material = |polygon: u32| {
        let materials = soup.attributes.materials.as_ref();
        let number =
            materials.and_then(|labels| labels.polygon_names.get(polygon as usize).copied());
        number
            .filter(|&number| (number as usize) < material_names(soup).len())
            .unwrap_or(NO_VALUE)
    };
    let mut objects: BTreeMap<usize, (Option<&str>, Vec<Triangle>)> = BTreeMap::new();
    let mut order = Numbering::<u32>::default();
    let mut partial = 0_usize;
    for (polygon, corners) in triangles(soup) {
        let label = labels.and_then(|labels| labels.polygon_names.get(polygon as usize).copied());
        let name = labels.and_then(|labels| labels.get(polygon as usize));
        let (number, _) = order.number(label.unwrap_or(NO_VALUE));
        let (_, object) = objects.entry(number as usize).or_insert((name, Vec::new()));
        let mut mask = 0;
        for (bit, column) in columns.iter().enumerate() {
            let there = corners
                .iter()
                .filter(|&&corner| column.index(corner) != NO_VALUE)
                .count();
            mask |= u32::from(there == 3) << bit;
            partial += usize::from(there == 1 || there == 2);
        }
        object.push(Triangle {
            corners,
            material: material(polygon),
            columns: mask,
        });
    }
    losses.lose(
        &format!("attributes at some corners of {partial} triangles only"),
        partial > 0,
    );
    objects.into_values().collect()
}

/// Whether no vertex belongs to polygons of two objects: vertices of different nodes are
/// different in the file.
fn objects_are_apart(soup: &PolygonSoup, labels: &PolygonLabels) -> bool {
    let mut owners = vec![None; soup.positions.len()];
    (0..soup.polygons.len()).all(|polygon| {
        let label = labels
            .polygon_names
            .get(polygon)
            .copied()
            .unwrap_or(NO_VALUE);
        let mut vertices = soup.polygons.vertices(polygon).iter();
        vertices.all(|&vertex| *owners[vertex as usize].get_or_insert(label) == label)
    })
}
