//! Squares laid side by side: texture coordinates for the whole surface.

use glam::DVec2;
use serde::Serialize;

use super::atlas_packing::{Cell, pack_cells};
use super::atlas_sizes::sizes_in_space;
use super::chart_map::ChartMaps;
use super::{ChartAtlasError, SquareId};
use crate::measure::orientation;
use crate::mesh::{Element, PerCorner};
use crate::tolerance::WHOLE_LENGTH;
use crate::watch::Watch;

/// Tiles in a row of the UDIM numbering.
pub const UDIM_COLUMNS: u32 = 10;

/// Least and largest side of a cell of a tile in spacings of the net: parts of it, so that charts of a
/// net without stretch have whole sizes.
const CELLS: [f64; 2] = [0.25, 0.5];

/// What sides of squares that keep the net may be multiples of, in its spacings.
const NET_UNITS: [f64; 6] = [1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125];

/// Most cells along the side of a tile.
const MOST_CELLS: f64 = 2048.0;

/// How squares are laid side by side.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Arrangement {
    /// Into the unit square, or into several, numbered as UDIM has them: tile `t` lies at
    /// (`t` mod 10, `t` / 10).
    Packed {
        /// Texels along the side of a tile.
        resolution: u32,
        /// Texels between two squares; half as many to the edge of the tile.
        padding: u32,
        /// How many tiles there are.
        tiles: Tiles,
    },
    /// At whole coordinates, in the size that they have on the net: a pattern that repeats with
    /// period 1 shows no seam where [`ChartSquare::keeps_net`](super::ChartSquare::keeps_net).
    Net,
}

/// The number of tiles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tiles {
    /// At most this many.
    AtMost(u32),
    /// As many as a density of so many texels in a unit of length needs.
    Density(f64),
}

impl Default for Arrangement {
    fn default() -> Self {
        Self::Packed {
            resolution: 2048,
            padding: 4,
            tiles: Tiles::AtMost(1),
        }
    }
}

/// The place of a square in an atlas.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Placement {
    /// The place of its origin.
    pub origin: DVec2,
    /// Its width and height.
    pub size: DVec2,
    /// The tile, counted from 0; always 0 on a net.
    pub tile: u32,
}

impl Placement {
    /// The place in the atlas of a place in the square.
    #[must_use]
    pub fn apply(&self, place: DVec2) -> DVec2 {
        self.origin + place * self.size
    }
}

/// Texture coordinates made of squares.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartAtlas {
    /// The texture coordinates of each corner.
    pub corner_uv: PerCorner<DVec2>,
    /// The place of each square.
    pub placements: Vec<Placement>,
    /// The number of tiles.
    pub tiles: u32,
    /// The share of the tiles that squares cover.
    pub covered: f64,
    /// Texels in a unit of length, for the surface as a whole; `None` on a net.
    pub density: Option<f64>,
    /// Triangles that rounding turned over, or that it left no area. Exact.
    pub flipped: usize,
}

/// Lays the squares of a surface side by side.
///
/// A square gets as many cells of the tile as its rectangle in space is long and wide, with four to a
/// spacing of the net, so that the density of texels is about the same everywhere.
///
/// Cost: linear in the triangles, and in cells times different sizes of squares.
///
/// # Errors
/// [`ChartAtlasError`].
pub fn chart_atlas(
    maps: &ChartMaps,
    arrangement: &Arrangement,
    watch: &Watch,
) -> Result<ChartAtlas, ChartAtlasError> {
    let _stage = watch.stage("atlas");
    let (placements, tiles, density) = match *arrangement {
        Arrangement::Net => (on_net(maps), 1, None),
        Arrangement::Packed {
            resolution,
            padding,
            tiles,
        } => {
            let tile = Tile::new(maps, resolution, padding)?;
            let (placements, count) = tile.pack(tiles, watch)?;
            let density = tile.density(&placements);
            (placements, count, Some(density))
        }
    };
    let corner_uv = PerCorner::from_fn(maps.coordinates().len(), |corner| {
        let square = maps.square_of()[corner.face()];
        placements[square.index()].apply(maps.coordinates()[corner])
    });
    let is_flipped = |face: &crate::mesh::FaceId| {
        let [a, b, c] = face.halfedges().map(|corner| corner_uv[corner]);
        orientation(a, b, c) <= 0
    };
    let flipped = maps.surface().mesh().faces().filter(is_flipped).count();
    if flipped > 0 {
        let message = format!(
            "double precision leaves {flipped} triangles of the atlas no area, or turns them"
        );
        watch.warn("flipped-triangles", message);
    }
    let area: f64 = placements.iter().map(|p| p.size.x * p.size.y).sum();
    Ok(ChartAtlas {
        corner_uv,
        covered: area / f64::from(tiles.max(1)),
        placements,
        tiles,
        density,
        flipped,
    })
}

/// A size whose sides are whole where they are but for rounding: neighbours without a gap would
/// overlap by it.
fn snapped(size: DVec2) -> DVec2 {
    let side = |side: f64| {
        let whole = side.round();
        let is_whole = (side - whole).abs() <= WHOLE_LENGTH;
        if is_whole { whole } else { side }
    };
    DVec2::new(side(size.x), side(size.y))
}

/// Squares at whole coordinates; in parts of a spacing if some squares have such sides.
fn on_net(maps: &ChartMaps) -> Vec<Placement> {
    let is_whole = |x: f64| (x - x.round()).abs() < WHOLE_LENGTH;
    let fits = |unit: &f64| {
        let mut kept = maps.squares().iter().filter(|square| square.keeps_net);
        kept.all(|s| is_whole(s.size.x / unit) && is_whole(s.size.y / unit))
    };
    let unit = NET_UNITS.into_iter().find(fits).unwrap_or(1.0);
    let sizes: Vec<DVec2> = maps
        .squares()
        .iter()
        .map(|s| snapped(s.size / unit).max(DVec2::splat(1e-3)))
        .collect();
    let cells: Vec<Cell> = sizes.iter().map(|size| Cell::around(*size)).collect();
    let mut side = Cell::least_side(&cells);
    let places = loop {
        if let Some(places) = pack_cells(&cells, side, 1) {
            break places;
        }
        side += 1;
    };
    let place = |([x, y], _): ([u32; 2], u32)| DVec2::new(f64::from(x), f64::from(y));
    let placed = places.into_iter().zip(sizes);
    placed
        .map(|(at, size)| Placement {
            origin: place(at),
            size,
            tile: 0,
        })
        .collect()
}

/// Cells of a tile for squares.
struct Tile {
    cells: Vec<Cell>,
    resolution: f64,
    padding: u32,
    /// Length in space of a cell's side, for the surface as a whole.
    cell_length: f64,
}

impl Tile {
    fn new(maps: &ChartMaps, resolution: u32, padding: u32) -> Result<Self, ChartAtlasError> {
        if resolution == 0 {
            return Err(ChartAtlasError::BadNumber {
                what: "the resolution",
                value: 0.0,
            });
        }
        let sizes = sizes_in_space(maps);
        let area: f64 = sizes.iter().map(|size| size.x * size.y).sum();
        let net_area: f64 = (maps.squares().iter())
            .map(|square| square.size.x * square.size.y)
            .sum();
        // Larger cells where most texels would go to the padding, or there would be too many.
        let padded = 2.0 * f64::from(padding) / f64::from(resolution);
        let wanted = net_area.sqrt() * padded;
        let cell = wanted
            .clamp(CELLS[0], CELLS[1])
            .max(net_area.sqrt() / MOST_CELLS);
        let unit = cell * (area / net_area).sqrt();
        let cells = sizes.iter().map(|&size| Cell::near(size / unit));
        let cells: Vec<Cell> = cells.collect();
        let count: u64 = cells.iter().map(|cell| cell.area()).sum();
        Ok(Self {
            cell_length: (area / count as f64).sqrt(),
            cells,
            resolution: f64::from(resolution),
            padding,
        })
    }

    /// The places of all squares and the number of tiles.
    #[expect(clippy::cast_sign_loss, reason = "lengths are not negative")]
    fn pack(&self, tiles: Tiles, watch: &Watch) -> Result<(Vec<Placement>, u32), ChartAtlasError> {
        let least = Cell::least_side(&self.cells);
        let longest = Cell::longest_side(&self.cells);
        let (mut side, most) = match tiles {
            Tiles::AtMost(0) => {
                return Err(ChartAtlasError::BadNumber {
                    what: "the number of tiles",
                    value: 0.0,
                });
            }
            Tiles::AtMost(count) => {
                let shared = f64::from(least) / f64::from(count).sqrt();
                (longest.max(shared.floor() as u32).max(1), count)
            }
            Tiles::Density(density) if density > 0.0 && density.is_finite() => {
                let texels = density * self.cell_length + f64::from(self.padding);
                (
                    ((self.resolution / texels).floor() as u32)
                        .clamp(1, 2 * least)
                        .max(longest),
                    u32::MAX,
                )
            }
            Tiles::Density(value) => {
                return Err(ChartAtlasError::BadNumber {
                    what: "the density",
                    value,
                });
            }
        };
        let places = loop {
            watch.check()?;
            if let Some(places) = pack_cells(&self.cells, side, most) {
                break places;
            }
            side += 1;
        };
        let count = places.iter().map(|&(_, tile)| tile + 1).max().unwrap_or(1);
        Ok((self.placements(&places, side)?, count))
    }

    fn placements(
        &self,
        places: &[([u32; 2], u32)],
        side: u32,
    ) -> Result<Vec<Placement>, ChartAtlasError> {
        let texels = self.resolution / f64::from(side);
        let padding = f64::from(self.padding);
        if texels <= padding {
            return Err(ChartAtlasError::Padding {
                texels,
                padding: self.padding,
            });
        }
        let placement = |(cell, &([x, y], tile)): (&Cell, &([u32; 2], u32))| {
            let corner = DVec2::new(f64::from(x), f64::from(y)) * texels + 0.5 * padding;
            let size = cell.size() * texels - padding;
            let shift = DVec2::new(
                f64::from(tile % UDIM_COLUMNS),
                f64::from(tile / UDIM_COLUMNS),
            );
            Placement {
                origin: shift + corner / self.resolution,
                size: size / self.resolution,
                tile,
            }
        };
        Ok(self.cells.iter().zip(places).map(placement).collect())
    }

    fn density(&self, placements: &[Placement]) -> f64 {
        let covered: f64 = placements.iter().map(|p| p.size.x * p.size.y).sum();
        let count: u64 = self.cells.iter().map(|cell| cell.area()).sum();
        let per_cell = covered.sqrt() * self.resolution / (count as f64).sqrt();
        per_cell / self.cell_length
    }
}

impl ChartAtlas {
    /// The UDIM number of a square's tile.
    #[must_use]
    pub fn udim(&self, square: SquareId) -> u32 {
        1001 + self.placements[square.index()].tile
    }
}
