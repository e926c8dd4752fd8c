//! The whole road, from the polygons of a file to a mesh of quads and a texture atlas, as one would
//! tell it.
//!
//! [`quads::remesh()`](crate::quads::remesh()) goes it in one call, meets the number of quads, and
//! looks after features. Step by step:
//!
//! ```
//! use graticule::charts::{
//!     Arrangement, ChartLines, ChartMapOptions, base_complex, chart_atlas, chart_maps, layout_from_map,
//! };
//! use graticule::field::{FieldOptions, cross_field};
//! use graticule::measure::measure_quads;
//! use graticule::mesh::{PolygonSoup, RepairOptions, repair};
//! use graticule::periodic::{GridDensity, IntegerGridOptions, integer_grid_map};
//! use graticule::quads::{Carry, Net, ShapeOptions, extract_polygons, pure_quads, shape};
//! use graticule::watch::Watch;
//!
//! // What a file holds: positions and polygons, nothing checked.
//! let torus = graticule_fixtures::torus(2.0, 0.7, 40, 16);
//! let mut soup = PolygonSoup { positions: torus.positions, ..PolygonSoup::default() };
//! torus.triangles.iter().for_each(|triangle| soup.polygons.push(triangle));
//!
//! // A sound surface, with the way back to the file.
//! let watch = Watch::new();
//! let repaired = repair(&soup, &RepairOptions::default(), &watch)?;
//! let surface = &repaired.surface;
//!
//! // Crosses along its curvature, and coordinates along the crosses.
//! let crosses = cross_field(surface, &FieldOptions::default(), &watch)?;
//! let options = IntegerGridOptions {
//!     density: GridDensity::Quads(300),
//!     ..IntegerGridOptions::default()
//! };
//! let net = integer_grid_map(surface, &crosses.field, &options, &watch)?;
//!
//! // The lines with whole coordinates bound polygons; those that are no quads are cut.
//! let found = extract_polygons(surface, &net.map, None, &watch)?;
//! let (mesh, cut) = pure_quads(&found.mesh, surface, &[]);
//! assert_eq!((mesh.quad_count(), cut.polygons_cut), (mesh.polygons.len(), 0));
//!
//! // Vertices find their places on the surface, and attributes of the file go over.
//! let unshaped = Net {
//!     surface,
//!     features: &[],
//!     polygons: &mesh.polygons,
//!     feature_edges: &mesh.feature_edges,
//! };
//! let shaped = shape(&unshaped, &mesh.origins, &ShapeOptions::default(), &watch)?;
//! let carry = Carry {
//!     original: &soup,
//!     repaired: &repaired,
//!     polygons: &mesh.polygons,
//!     origins: &shaped.origins,
//! };
//! let measure = measure_quads(&carry.to_soup(), &watch)?;
//! assert_eq!(measure.valences.irregular, 0);
//!
//! // The same lines cut the surface into charts; each is laid on a square, and all side by side.
//! let coarse = IntegerGridOptions {
//!     density: GridDensity::Quads(40),
//!     ..IntegerGridOptions::default()
//! };
//! let net = integer_grid_map(surface, &crosses.field, &coarse, &watch)?;
//! let (layout, _) = layout_from_map(surface, &net.map, &[], ChartLines::All, &watch)?;
//! assert_eq!(base_complex(&layout).euler_characteristic(), 0);
//! let maps = chart_maps(surface, &layout, &ChartMapOptions::default(), &watch)?;
//! let atlas = chart_atlas(&maps, &Arrangement::default(), &watch)?;
//! assert_eq!(atlas.flipped, 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
