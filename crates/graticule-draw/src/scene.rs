use glam::{DVec2, DVec3};

use crate::{Color, ColorMap, DrawError, Frame, MAX_SIDE};

/// Width and height of one panel, unless the picture has a size of its own.
const PANEL_SIDE: u32 = 800;

/// Panels in rows; written as PNG or SVG.
///
/// The bytes are the same for any number of threads.
#[derive(Clone, Debug)]
pub struct Picture {
    pub(crate) panels: Vec<Panel>,
    pub(crate) columns: usize,
    size: Option<[u32; 2]>,
    /// The colour behind everything.
    pub background: Color,
}

/// Panels in one row, as a picture.
#[must_use]
pub fn side_by_side(panels: Vec<Panel>) -> Picture {
    Picture {
        columns: panels.len().max(1),
        panels,
        size: None,
        background: Color::WHITE,
    }
}

impl From<Panel> for Picture {
    fn from(panel: Panel) -> Self {
        side_by_side(vec![panel])
    }
}

impl Picture {
    /// The same panels in rows of `columns`; at least one.
    #[must_use]
    pub fn with_columns(mut self, columns: usize) -> Self {
        self.columns = columns.max(1);
        self
    }

    /// The same picture with this width and height in pixels.
    ///
    /// # Errors
    /// [`DrawError::PictureSize`] unless both are in `16..=MAX_SIDE`.
    pub fn with_size(mut self, width: u32, height: u32) -> Result<Self, DrawError> {
        if [width, height]
            .iter()
            .any(|side| !(16..=MAX_SIDE).contains(side))
        {
            return Err(DrawError::PictureSize { width, height });
        }
        self.size = Some([width, height]);
        Ok(self)
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        let side = |count: usize| (count as u32).saturating_mul(PANEL_SIDE).min(MAX_SIDE);
        self.size
            .unwrap_or_else(|| [side(self.columns), side(self.rows())])
    }

    pub(crate) fn rows(&self) -> usize {
        self.panels.len().div_ceil(self.columns).max(1)
    }
}

/// One drawing: layers seen by one eye, with legend and caption.
///
/// Triangles lie below lines, lines below points; within a kind, later layers lie on top. In space
/// what is nearer hides what is farther.
#[derive(Clone, Debug)]
pub struct Panel {
    /// From where the layers are seen.
    pub eye: Eye,
    /// What is drawn.
    pub layers: Vec<Layer>,
    /// What the colours mean.
    pub legend: Option<Legend>,
    /// A line or two below the drawing.
    pub caption: Option<String>,
    /// Facts about the drawing that its reader must know, such as what was left out; after the
    /// caption.
    pub notes: Vec<String>,
}

impl Panel {
    /// Layers seen by an eye, without legend and text.
    #[must_use]
    pub fn new(eye: Eye, layers: Vec<Layer>) -> Self {
        Self {
            eye,
            layers,
            legend: None,
            caption: None,
            notes: Vec::new(),
        }
    }

    /// The same panel with a caption.
    #[must_use]
    pub fn with_caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = Some(caption.into());
        self
    }

    /// The same panel with another layer on top.
    #[must_use]
    pub fn with_layer(mut self, layer: impl Into<Layer>) -> Self {
        self.layers.push(layer.into());
        self
    }
}

/// How positions come to the drawing. Every panel is scaled to show all of its layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Eye {
    /// x to the right, y up, z ignored; the last triangle drawn is on top.
    Plane,
    /// Along parallel lines.
    Orthographic(Frame),
    /// From a point at four times the extent of the layers: near parts are a little larger.
    Perspective(Frame),
}

/// A part of a drawing.
#[derive(Clone, Debug)]
pub enum Layer {
    /// Filled triangles.
    Triangles(Triangles),
    /// Polylines.
    Lines(Lines),
    /// Dots.
    Points(Points),
}

impl From<Triangles> for Layer {
    fn from(triangles: Triangles) -> Self {
        Self::Triangles(triangles)
    }
}

impl From<Lines> for Layer {
    fn from(lines: Lines) -> Self {
        Self::Lines(lines)
    }
}

impl From<Points> for Layer {
    fn from(points: Points) -> Self {
        Self::Points(points)
    }
}

impl Layer {
    /// All positions of the layer.
    pub(crate) fn positions(&self) -> &[DVec3] {
        match self {
            Self::Triangles(triangles) => &triangles.positions,
            Self::Lines(lines) => &lines.positions,
            Self::Points(points) => &points.positions,
        }
    }
}

/// Filled triangles. Those with a position that is not finite are left out.
#[derive(Clone, Debug)]
pub struct Triangles {
    /// Positions of the vertices.
    pub positions: Vec<DVec3>,
    /// Indices into [`positions`](Self::positions), counter-clockwise seen from the near side.
    pub triangles: Vec<[u32; 3]>,
    /// The colour before shading.
    pub paint: Paint,
    /// Squares that darken the colour.
    pub checker: Option<Checker>,
    /// How the triangles take the light.
    pub shading: Shading,
}

/// The colour of triangles before checker and shading.
#[derive(Clone, Debug)]
pub enum Paint {
    /// One colour for all.
    Uniform(Color),
    /// A colour for each triangle.
    PerFace(Vec<Color>),
    /// A number for each vertex, interpolated in the triangles: 0 gets the low end of the map, 1
    /// the high end, NaN is missing.
    PerVertex(Vec<f32>, ColorMap),
}

/// A checker of unit squares, given by coordinates at the corners of each triangle; squares with
/// an odd sum of their whole coordinates are dark. A triangle whose coordinates are not finite has
/// the colour [`Color::MISSING`].
#[derive(Clone, Debug)]
pub struct Checker {
    /// For each corner of each triangle its place in the checker.
    pub corners: Vec<[[f32; 2]; 3]>,
    /// Multiplies the colour of the dark squares.
    pub dark: Color,
}

/// How triangles take the light.
#[derive(Clone, Debug)]
pub enum Shading {
    /// Not at all: the plain colour.
    Unlit,
    /// Each triangle by its own normal.
    Flat,
    /// By unit normals at the corners of each triangle, interpolated.
    Smooth(Vec<[[f32; 3]; 3]>),
}

/// Polylines of one colour and width.
#[derive(Clone, Debug)]
pub struct Lines {
    positions: Vec<DVec3>,
    /// The first position of each polyline, and the number of positions in the end.
    starts: Vec<usize>,
    /// The colour.
    pub color: Color,
    /// Width in thousandths of the smaller side of the panel.
    pub width: f64,
    /// From 0, invisible, to 1, opaque.
    pub opacity: f32,
    /// Whether the lines grow fainter, and vanish, where there are so many that they would blacken
    /// the drawing; for the edges of meshes.
    pub fades: bool,
}

impl Lines {
    /// No lines yet; opaque.
    #[must_use]
    pub fn new(color: Color, width: f64) -> Self {
        Self {
            positions: Vec::new(),
            starts: vec![0],
            color,
            width,
            opacity: 1.0,
            fades: false,
        }
    }

    /// Adds a polyline. A closed one ends where it began.
    pub fn push(&mut self, polyline: impl IntoIterator<Item = DVec3>) {
        self.positions.extend(polyline);
        self.starts.push(self.positions.len());
    }

    /// The polylines.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[DVec3]> {
        self.starts
            .windows(2)
            .map(|ends| &self.positions[ends[0]..ends[1]])
    }

    /// Whether there is no polyline.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.starts.len() == 1
    }
}

/// Dots of one colour and size.
#[derive(Clone, Debug)]
pub struct Points {
    /// Where they lie.
    pub positions: Vec<DVec3>,
    /// The colour.
    pub color: Color,
    /// Radius in thousandths of the smaller side of the panel.
    pub radius: f64,
    /// Whether only a ring is drawn, to leave open what lies below.
    pub ring: bool,
}

/// What the colours of a panel mean: a bar from the low to the high end of the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Legend {
    /// Name of the figure, with its unit.
    pub title: String,
    /// The colours.
    pub map: ColorMap,
    /// The value at the low end; finite.
    pub low: f64,
    /// The value at the high end; finite.
    pub high: f64,
    /// How many values lie below [`low`](Self::low); marked by an arrow.
    pub below: usize,
    /// How many values lie above [`high`](Self::high); marked by an arrow.
    pub above: usize,
    /// How many elements have no value; shown by a swatch.
    pub missing: usize,
}

/// A position in a plane as a position in space.
pub(crate) fn in_plane(position: DVec2) -> DVec3 {
    position.extend(0.0)
}
