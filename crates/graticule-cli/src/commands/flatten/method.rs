//! From the options to the library's methods.

use glam::DVec2;
use graticule::flatten::{
    BoundaryCurve, BoundaryOptimalOptions, BoundaryPositions, BoundaryTarget, ConstrainedMap,
    Corners, Extension, FixedOptions, FlatMap, Functional, Holes, LambdaValue, Mix, NaturalOptions,
    NearOptimalOptions, Patch, Pins, PointConstraint, Strength, TargetOptions, Triangulation,
    Weights, boundary_on_curve, boundary_optimal_map, constrained_fixed_map,
    constrained_natural_map, fixed_map, line_constraints, natural_map, near_optimal_map,
    spectral_map, target_map,
};
use graticule::measure::corner_uvs;
use graticule::mesh::{EdgeId, HalfedgeId, PerCorner, PerVertex, PolygonSoup, Repaired, VertexId};
use graticule::watch::Watch;
use serde_json::{Value, json};

use super::file_vertices::{FileVertices, Refusal};
use super::options::{
    Boundary, ExtensionArgument, FunctionalArgument, HolesArgument, Method, Options,
    WeightsArgument,
};
use super::piece::Piece;
use super::told::Told;
use crate::failure::Failure;

/// What a method has made.
pub(super) struct Made {
    pub(super) map: FlatMap,
    /// The vertex of the map at each corner of the piece, where that was cut open for it.
    pub(super) cut: Option<PerCorner<VertexId>>,
    /// What the report tells beside the map itself, by key.
    pub(super) details: Value,
    /// What the picture shows beside the map.
    pub(super) illustration: Option<Illustration>,
}

/// How a map came about.
pub(super) struct Illustration {
    /// The map at the start, and what it is.
    pub(super) before: PerVertex<DVec2>,
    pub(super) before_name: &'static str,
    /// A curve with a marked point and what it shows.
    pub(super) curve: Vec<[f64; 2]>,
    pub(super) marked: [f64; 2],
    pub(super) caption: String,
}

impl Made {
    /// The coordinates at the corners of the piece.
    pub(super) fn corners(&self, piece: &Piece, uv: &PerVertex<DVec2>) -> PerCorner<DVec2> {
        match &self.cut {
            Some(cut) => cut.map(|&vertex| uv[vertex]),
            None => corner_uvs(piece.surface.mesh(), uv),
        }
    }

    fn plain(map: FlatMap) -> Self {
        Self {
            map,
            cut: None,
            details: json!({}),
            illustration: None,
        }
    }
}

/// What the methods work on.
pub(super) struct Task<'a> {
    pub(super) options: &'a Options,
    pub(super) soup: &'a PolygonSoup,
    pub(super) repaired: &'a Repaired,
    pub(super) piece: &'a Piece,
    pub(super) watch: &'a Watch,
}

impl Task<'_> {
    /// The map that the options ask for.
    pub(super) fn run(&self) -> Result<Made, Failure> {
        let patch = Patch::new(self.piece.surface.clone(), self.watch)?;
        let file = FileVertices::of(self.soup, self.repaired, self.piece);
        self.made(&patch, &file)
            .map_err(|refusal| file.told(refusal))
    }

    fn made(&self, patch: &Patch, file: &FileVertices<'_>) -> Result<Made, Refusal> {
        let options = self.options;
        let constraints = constraints(options, patch, file)?;
        match options.method {
            Method::Natural if !constraints.is_empty() => {
                let triangulation = triangulation(options);
                let made = constrained_natural_map(patch, &constraints, triangulation, self.watch)?;
                Ok(constrained(made))
            }
            Method::Natural => {
                let options = natural_options(options, file)?;
                Ok(Made::plain(natural_map(patch, &options, self.watch)?))
            }
            Method::Spectral => {
                let map = spectral_map(patch, triangulation(options), self.watch)?;
                Ok(Made::plain(map))
            }
            Method::Fixed => self.fixed(patch, file, &constraints),
            Method::Optimal => self.near_optimal(patch, file),
            Method::BoundaryOptimal => self.boundary_optimal(patch, file),
            Method::Target => self.target(patch, file),
        }
    }

    fn boundary(
        &self,
        patch: &Patch,
        file: &FileVertices<'_>,
    ) -> Result<BoundaryPositions, Refusal> {
        match self.options.boundary {
            Some(Boundary::Given) => Ok(BoundaryPositions::new(patch, given_places(self, patch)?)?),
            Some(Boundary::Natural) => {
                let options = NaturalOptions {
                    triangulation: triangulation(self.options),
                    ..NaturalOptions::default()
                };
                let natural = natural_map(patch, &options, self.watch)?;
                Ok(BoundaryPositions::of_map(patch, &natural.uv)?)
            }
            _ => {
                let curve = curve(self.options, patch, file)?;
                Ok(boundary_on_curve(patch, &curve, self.watch)?)
            }
        }
    }

    fn fixed(
        &self,
        patch: &Patch,
        file: &FileVertices<'_>,
        constraints: &[PointConstraint],
    ) -> Result<Made, Refusal> {
        let boundary = self.boundary(patch, file)?;
        let options = fixed_options(self.options)?;
        if constraints.is_empty() {
            let map = fixed_map(patch, &boundary, &options, self.watch)?;
            return Ok(Made::plain(map));
        }
        let made = constrained_fixed_map(patch, &boundary, constraints, &options, self.watch)?;
        Ok(constrained(made))
    }

    fn near_optimal(&self, patch: &Patch, file: &FileVertices<'_>) -> Result<Made, Refusal> {
        let boundary = self.boundary(patch, file)?;
        let options = NearOptimalOptions {
            functional: functional(self.options),
            holes: holes(self.options),
        };
        let found = near_optimal_map(patch, &boundary, options, self.watch)?;
        let LambdaValue { lambda, value } = found.best;
        let details = json!({ "near_optimal": {
            "functional": options.functional,
            "lambda": lambda,
            "value": value,
            "candidates": found.candidates,
            "curve": found.curve,
            "scale": found.scale,
        }});
        let name = functional_name(options.functional);
        let [conformal, _] = found.bases;
        let ends = [found.curve.first(), found.curve.last()];
        let [low, high] = ends.map(|end| end.map_or(lambda, |point| point.lambda));
        Ok(Made {
            map: found.map,
            cut: None,
            details,
            illustration: Some(Illustration {
                before: conformal,
                before_name: "conformal, before",
                curve: found.curve.iter().map(|p| [p.lambda, p.value]).collect(),
                marked: [lambda, value],
                caption: format!(
                    "{name} over λ from {low:.1} to {high:.1} · least at λ = {lambda:.3}"
                ),
            }),
        })
    }

    fn boundary_optimal(&self, patch: &Patch, file: &FileVertices<'_>) -> Result<Made, Refusal> {
        let boundary = self.boundary(patch, file)?;
        let default = BoundaryOptimalOptions::default();
        let options = BoundaryOptimalOptions {
            functional: functional(self.options),
            fixed: fixed_options(self.options)?,
            most_steps: self.options.steps.unwrap_or(default.most_steps),
        };
        let found = boundary_optimal_map(patch, &boundary, &options, self.watch)?;
        let details = json!({ "descent": {
            "functional": options.functional,
            "at_rest": found.at_rest,
            "left_out": found.left_out,
            "history": found.history,
        }});
        let values = found.history.iter().enumerate();
        let curve: Vec<_> = values.map(|(k, step)| [k as f64, step.value]).collect();
        let name = functional_name(options.functional);
        Ok(Made {
            map: found.map,
            cut: None,
            details,
            illustration: curve.last().copied().map(|marked| Illustration {
                before: found.start,
                before_name: "start",
                caption: format!("{name} over {} steps of descent", marked[0]),
                curve,
                marked,
            }),
        })
    }

    fn target(&self, patch: &Patch, file: &FileVertices<'_>) -> Result<Made, Refusal> {
        let told = |told: &[Told], unit: f64| -> Result<Vec<(VertexId, f64)>, Failure> {
            let pair = |told: &Told| Ok((corner(told.vertex, patch, file)?, told.number * unit));
            told.iter().map(pair).collect()
        };
        let options = self.options;
        let degree = 1.0_f64.to_radians();
        let target = if options.target_angle.is_empty() {
            BoundaryTarget::Scales(told(&options.target_scale, 1.0)?)
        } else {
            BoundaryTarget::Angles(told(&options.target_angle, degree)?)
        };
        let cones = options.cone.iter().map(|cone| {
            let vertex = inner_vertex(cone.vertex, patch, file)?;
            Ok((vertex, cone.number * degree))
        });
        let options = TargetOptions {
            target,
            cones: cones.collect::<Result<_, Failure>>()?,
            uncut: self.diagonals(),
            extension: match options.extension {
                Some(ExtensionArgument::Conjugate) => Extension::Conjugate,
                Some(ExtensionArgument::Harmonic) | None => Extension::Harmonic,
            },
            triangulation: triangulation(options),
        };
        let found = target_map(patch, &options, self.watch)?;
        let cut_mesh = found.patch.mesh();
        let at_corner = |corner| cut_mesh.origin(corner);
        let cut = PerCorner::from_fn(cut_mesh.halfedge_count(), at_corner);
        let details = json!({ "target": {
            "closing_change": found.closing_change,
            "cones": options.cones.len(),
            "vertices_added": found.patch.mesh().vertex_count() - patch.mesh().vertex_count(),
        }});
        Ok(Made {
            cut: (!options.cones.is_empty()).then_some(cut),
            map: found.map,
            details,
            illustration: None,
        })
    }

    /// The diagonals that repair gave polygons: no cut can be written there.
    fn diagonals(&self) -> Vec<EdgeId> {
        let whole = self.repaired.surface.mesh();
        let sides = whole.edges().map(|edge| whole.edge_halfedge(edge));
        let diagonal = sides.filter(|&side| is_diagonal(self.repaired, side));
        let own = diagonal.filter_map(|side| self.piece.corner(side));
        own.map(|side| self.piece.surface.mesh().edge(side))
            .collect()
    }
}

/// Whether the edge of a side runs inside a polygon of the file.
pub(super) fn is_diagonal(repaired: &Repaired, side: HalfedgeId) -> bool {
    let polygons = &repaired.face_polygons;
    let twin = repaired.surface.mesh().twin(side);
    twin.is_some_and(|twin| polygons[side.face()] == polygons[twin.face()])
}

fn constrained(made: ConstrainedMap) -> Made {
    let details = json!({ "constraints": {
        "count": made.misses.len(),
        "redundant": made.redundant,
        "misses": made.misses,
    }});
    Made {
        details,
        ..Made::plain(made.map)
    }
}

/// The constraints asked for, lines after points.
fn constraints(
    options: &Options,
    patch: &Patch,
    file: &FileVertices<'_>,
) -> Result<Vec<PointConstraint>, Refusal> {
    let strength = options.soft.map_or(Strength::Hard, Strength::Soft);
    let mut constraints = Vec::new();
    for told in &options.constraint {
        constraints.push(PointConstraint {
            point: file.point(&told.point, patch)?,
            place: told.place,
            strength,
        });
    }
    for line in &options.line {
        let [from, to] = &line.ends;
        let ends = [file.point(from, patch)?, file.point(to, patch)?];
        constraints.extend(line_constraints(patch, ends, line.places, strength)?);
    }
    Ok(constraints)
}

fn triangulation(options: &Options) -> Triangulation {
    if options.intrinsic_delaunay {
        Triangulation::IntrinsicDelaunay
    } else {
        Triangulation::Given
    }
}

fn natural_options(options: &Options, file: &FileVertices<'_>) -> Result<NaturalOptions, Failure> {
    let pins = match options.pin[..] {
        [first, second] => Pins::At([
            (file.find(first.vertex)?, first.place),
            (file.find(second.vertex)?, second.place),
        ]),
        _ => Pins::Farthest,
    };
    Ok(NaturalOptions {
        pins,
        triangulation: triangulation(options),
    })
}

fn fixed_options(options: &Options) -> Result<FixedOptions, Failure> {
    let weights = match options.weights {
        _ if options.lambda.is_some() || options.mu.is_some() => Weights::Intrinsic(options.mix()?),
        Some(WeightsArgument::MeanValue) => Weights::MeanValue,
        Some(WeightsArgument::Uniform) => Weights::Uniform,
        Some(WeightsArgument::Authalic) => Weights::Intrinsic(Mix::AUTHALIC),
        Some(WeightsArgument::Cotangent) | None if options.intrinsic_delaunay => {
            Weights::DelaunayCotangent
        }
        Some(WeightsArgument::Cotangent) | None => Weights::Cotangent,
    };
    Ok(FixedOptions {
        weights,
        holes: holes(options),
    })
}

fn holes(options: &Options) -> Holes {
    match options.holes {
        Some(HolesArgument::Natural) => Holes::Natural,
        Some(HolesArgument::Filled) => Holes::Closed,
        Some(HolesArgument::Fixed) | None => Holes::default(),
    }
}

fn functional(options: &Options) -> Functional {
    match options.functional {
        Some(FunctionalArgument::EdgeLength) | None => Functional::EdgeLength,
        Some(FunctionalArgument::Area) => Functional::Area,
        Some(FunctionalArgument::Stretch) => Functional::Stretch,
        Some(FunctionalArgument::SymmetricDirichlet) => Functional::SymmetricDirichlet,
    }
}

fn functional_name(functional: Functional) -> &'static str {
    match functional {
        Functional::EdgeLength => "edge length distortion",
        Functional::Area => "area distortion",
        Functional::Stretch => "stretch",
        Functional::SymmetricDirichlet => "symmetric Dirichlet energy",
    }
}

fn curve(
    options: &Options,
    patch: &Patch,
    file: &FileVertices<'_>,
) -> Result<BoundaryCurve, Failure> {
    let corners = match options.corner[..] {
        [a, b, c, d] => Corners::At([
            corner(a, patch, file)?,
            corner(b, patch, file)?,
            corner(c, patch, file)?,
            corner(d, patch, file)?,
        ]),
        _ => Corners::Automatic,
    };
    Ok(match options.boundary {
        Some(Boundary::Square) => BoundaryCurve::Square(corners),
        Some(Boundary::Rectangle) => BoundaryCurve::Rectangle {
            aspect: options.aspect,
            corners,
        },
        _ => BoundaryCurve::Circle,
    })
}

/// A corner by its number in the file, which an error must name rather than that in the patch.
fn corner(number: u32, patch: &Patch, file: &FileVertices<'_>) -> Result<VertexId, Failure> {
    let vertex = file.find(number)?;
    let mut outer = patch.loop_vertices(patch.outer_loop());
    if outer.any(|on_loop| on_loop == vertex) {
        return Ok(vertex);
    }
    Err(Failure::new(
        format!("vertex {number} of the file is not on the outer boundary loop"),
        "choose four different vertices of the outer boundary",
    ))
}

/// A vertex inside by its number in the file.
fn inner_vertex(number: u32, patch: &Patch, file: &FileVertices<'_>) -> Result<VertexId, Failure> {
    let vertex = file.find(number)?;
    if patch.mesh().is_boundary_vertex(vertex) {
        return Err(Failure::new(
            format!("vertex {number} of the file lies on the boundary"),
            "choose a vertex inside for a cone; --target-angle bends the boundary",
        ));
    }
    Ok(vertex)
}

/// Where the file's own texture coordinates put the boundary: the outer loop, and the holes if the
/// options fix them.
fn given_places(task: &Task<'_>, patch: &Patch) -> Result<Vec<(VertexId, DVec2)>, Failure> {
    let Task {
        options,
        soup,
        repaired,
        piece,
        watch,
    } = task;
    let Some(set) = soup.attributes.uv_sets.first() else {
        return Err(Failure::new(
            "the mesh has no texture coordinates to take the boundary from",
            "choose a curve: --boundary circle, square or rectangle",
        ));
    };
    let mut places = PerVertex::filled(patch.mesh().vertex_count(), None);
    let mut has_several = PerVertex::filled(patch.mesh().vertex_count(), false);
    for (corner, &source) in repaired.corner_sources.enumerate() {
        let vertex = piece.vertex(repaired.surface.mesh().origin(corner));
        if let (Some(vertex), Some(place)) = (vertex, set.get(source as usize)) {
            has_several[vertex] |= *places[vertex].get_or_insert(place) != place;
        }
    }
    let holes = patch.holes().flat_map(|hole| patch.loop_vertices(hole));
    let holes = holes.filter(|_| options.holes == Some(HolesArgument::Fixed));
    let outer = patch.loop_vertices(patch.outer_loop());
    let vertices: Vec<_> = outer.chain(holes).collect();
    let several = vertices.iter().filter(|&&v| has_several[v]).count();
    if several > 0 {
        let message = format!(
            "boundary vertices with several texture coordinates: {several}; the first is taken"
        );
        watch.warn("several-coordinates", message);
    }
    let vertices = vertices.into_iter();
    Ok(vertices
        .filter_map(|vertex| Some((vertex, places[vertex]?)))
        .collect())
}
