//! Directions and lines that the field should follow, by the numbers of the file.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use glam::DVec3;
use graticule::field::{Guide, GuidePlace, Strength, Stroke};
use graticule::mesh::{EdgeId, FaceId, NO_VALUE, PolygonSoup, Repaired, VertexId};
use graticule_io::read_polylines;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::failure::Failure;
use crate::lines::Lines;
use crate::output::extension;

/// The guides of a file.
#[derive(Default)]
pub(super) struct Wishes {
    /// Directions, each with its number in the file.
    directions: Vec<(usize, Wish)>,
    /// Strokes, likewise.
    strokes: Vec<(usize, Stroke)>,
}

/// One guide as the file has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Wish {
    vertex: Option<u32>,
    face: Option<u32>,
    direction: Option<[f64; 3]>,
    stroke: Option<Vec<[f64; 3]>>,
    weight: Option<f64>,
}

impl Wish {
    fn strength(&self) -> Strength {
        self.weight.map_or(Strength::Hard, Strength::Soft)
    }

    /// Whether it is a direction at one place, or a stroke.
    fn is_plain(&self) -> bool {
        let places = [self.vertex, self.face].iter().flatten().count();
        match (&self.direction, &self.stroke) {
            (Some(_), None) => places == 1,
            (None, Some(_)) => places == 0,
            _ => false,
        }
    }
}

impl Wishes {
    /// Reads the file, if there is one.
    pub(super) fn read(path: Option<&Path>) -> Result<Self, Failure> {
        match path {
            None => Ok(Self::default()),
            Some(path) if extension(path) == "obj" => Self::read_lines(path),
            Some(path) => Self::read_json(path),
        }
    }

    /// The lines of an OBJ file.
    fn read_lines(path: &Path) -> Result<Self, Failure> {
        let lines =
            read_polylines(path).map_err(|error| Failure::from(error).at(path.display()))?;
        let strokes = lines.into_iter().map(|points| Stroke {
            points,
            strength: Strength::Hard,
        });
        let strokes: Vec<(usize, Stroke)> = strokes.enumerate().collect();
        if strokes.is_empty() {
            return Err(Failure::new(
                format!("{} holds no lines", path.display()),
                "draw guides as 'l' elements of the OBJ file, or give a JSON file",
            ));
        }
        Ok(Self {
            directions: Vec::new(),
            strokes,
        })
    }

    fn read_json(path: &Path) -> Result<Self, Failure> {
        let example = "[{\"vertex\": 7, \"direction\": [1, 0, 0], \"weight\": 5}]";
        let wishes: Vec<Wish> = read_list(path, "guides", example)?;
        let mut read = Self::default();
        for (number, wish) in wishes.into_iter().enumerate() {
            if !wish.is_plain() {
                return Err(Failure::new(
                    format!("guide {number} of {} needs a place", path.display()),
                    "give it a direction and either a vertex or a face, by its number in the mesh \
                     file, or a stroke alone",
                ));
            }
            match &wish.stroke {
                None => read.directions.push((number, wish)),
                Some(points) => {
                    let points = points.iter().map(|&p| DVec3::from_array(p)).collect();
                    let strength = wish.strength();
                    read.strokes.push((number, Stroke { points, strength }));
                }
            }
        }
        Ok(read)
    }

    /// The strokes, each with its number in the file.
    pub(super) fn strokes(&self) -> &[(usize, Stroke)] {
        &self.strokes
    }

    /// The guides on the surface, each with its number in the file. A polygon that was cut has one
    /// for each of its triangles.
    pub(super) fn on_surface(
        &self,
        soup: &PolygonSoup,
        repaired: &Repaired,
    ) -> Result<Vec<(usize, Guide)>, Failure> {
        if self.directions.is_empty() {
            return Ok(Vec::new());
        }
        let vertices = repaired.mesh_vertices(soup);
        let triangles = triangles_of_polygons(repaired);
        let mut guides = Vec::new();
        for &(number, ref wish) in &self.directions {
            let places: Vec<GuidePlace> = match (wish.vertex, wish.face) {
                (Some(vertex), _) => (vertices.get(vertex as usize).into_iter())
                    .filter(|&&vertex| vertex != NO_VALUE)
                    .map(|&vertex| GuidePlace::Vertex(VertexId(vertex)))
                    .collect(),
                (None, Some(face)) => (triangles.get(&face).into_iter().flatten())
                    .map(|&face| GuidePlace::Face(face))
                    .collect(),
                (None, None) => Vec::new(),
            };
            if places.is_empty() {
                return Err(nowhere(number, wish));
            }
            let guide = |place| Guide {
                place,
                direction: DVec3::from_array(wish.direction.unwrap_or_default()),
                strength: wish.strength(),
            };
            guides.extend(places.into_iter().map(|place| (number, guide(place))));
        }
        Ok(guides)
    }
}

fn nowhere(number: usize, wish: &Wish) -> Failure {
    let place = match (wish.vertex, wish.face) {
        (Some(vertex), _) => format!("vertex {vertex}"),
        (None, face) => format!("face {}", face.unwrap_or_default()),
    };
    Failure::new(
        format!("guide {number} is for {place}, which is no part of the surface"),
        "elements are numbered from 0 in the order of the mesh file; 'graticule info' tells what \
         repair drops",
    )
}

/// The triangles of each polygon of the file.
pub(super) fn triangles_of_polygons(repaired: &Repaired) -> BTreeMap<u32, Vec<FaceId>> {
    let mut triangles = BTreeMap::<u32, Vec<FaceId>>::new();
    for (face, &polygon) in repaired.face_polygons.enumerate() {
        triangles.entry(polygon).or_default().push(face);
    }
    triangles
}

/// The list that a JSON file holds.
pub(super) fn read_list<T: DeserializeOwned>(
    path: &Path,
    what: &str,
    example: &str,
) -> Result<Vec<T>, Failure> {
    let text = fs::read(path).map_err(|error| {
        Failure::new(
            format!("{} could not be read: {error}", path.display()),
            "check its name and the rights to it",
        )
    })?;
    serde_json::from_slice(&text).map_err(|error| {
        Failure::new(
            format!("{} is no list of {what}: {error}", path.display()),
            format!("write {example}"),
        )
    })
}

/// A polyline of a file as a stroke that is kept exactly.
fn stroke(soup: &PolygonSoup, line: &[u32]) -> Stroke {
    let points = line.iter().map(|&vertex| soup.positions[vertex as usize]);
    Stroke {
        points: points.collect(),
        strength: Strength::Hard,
    }
}

/// What the polylines of the mesh file ask for: edges of the surface where they run along some, and
/// strokes where they do not.
pub(crate) fn lines_of_file(soup: &PolygonSoup, repaired: &Repaired) -> (Vec<EdgeId>, Vec<Stroke>) {
    let Lines { edges, beside } = Lines::of(soup, repaired);
    let strokes = beside.iter().map(|segment| stroke(soup, segment));
    (edges, strokes.collect())
}
