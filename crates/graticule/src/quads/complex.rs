use super::cells::Cells;
use super::overlay::{ArcKind, NONE, Overlay, arc, twin};

/// The net as a cell complex: nodes where at least three lines meet, arcs between them, cells.
///
/// Arcs come as two darts, `2a` and `2a + 1`, as in the [`Overlay`], whose numbering the nodes keep.
/// Arcs may be loops, and two may have the same ends, until [`make_regular`] has seen to it.
///
/// [`make_regular`]: super::regular::make_regular
pub(super) struct Complex {
    /// The node that each dart leaves from; [`NONE`] for darts taken away.
    pub(super) origins: Vec<u32>,
    pub(super) next: Vec<u32>,
    pub(super) previous: Vec<u32>,
    /// The cell to the left; [`NONE`] outside.
    pub(super) cells: Vec<u32>,
    pub(super) kinds: Vec<ArcKind>,
    /// How far each arc leads along its line, in spacings.
    pub(super) advances: Vec<f64>,
    /// The nodes of the overlay inside each arc, in the direction of its even dart.
    paths: Vec<(u32, u32)>,
    path_nodes: Vec<u32>,
}

impl Complex {
    /// Reads the net off the overlay. Linear.
    pub(super) fn of(overlay: &Overlay, cells: &Cells) -> Self {
        let corners = corners(overlay);
        let mut complex = Self {
            origins: Vec::new(),
            next: Vec::new(),
            previous: Vec::new(),
            cells: Vec::new(),
            kinds: Vec::new(),
            advances: Vec::new(),
            paths: Vec::new(),
            path_nodes: Vec::new(),
        };
        let mut names = vec![NONE; overlay.origins.len()];
        let mut lasts = Vec::new();
        for dart in overlay.darts() {
            let corner = corners[overlay.origins[dart as usize] as usize];
            if corner && overlay.is_drawn(dart) && names[dart as usize] == NONE {
                let name = complex.origins.len() as u32;
                let last = complex.add_chain(overlay, cells, &corners, dart);
                names[dart as usize] = name;
                names[twin(last) as usize] = twin(name);
                lasts.extend([last, twin(dart)]);
            }
        }
        complex.next = (lasts.iter())
            .map(|&last| names[overlay.next_drawn(last) as usize])
            .collect();
        complex.previous = vec![NONE; complex.next.len()];
        for (dart, &next) in complex.next.iter().enumerate() {
            complex.previous[next as usize] = dart as u32;
        }
        complex
    }

    /// Follows the net from a corner to the next one; returns the last dart of the overlay.
    fn add_chain(&mut self, overlay: &Overlay, cells: &Cells, corners: &[bool], first: u32) -> u32 {
        let start = self.path_nodes.len() as u32;
        let mut last = first;
        let (mut advance, mut kind) = (0.0, LongestKind::default());
        loop {
            advance += overlay.advances[arc(last)];
            kind.add(overlay, last);
            if corners[overlay.destination(last) as usize] {
                break;
            }
            self.path_nodes.push(overlay.destination(last));
            last = overlay.next_drawn(last);
        }
        let cell_of = |dart: u32| {
            let face = overlay.faces[dart as usize];
            (cells.of_face.get(face as usize)).map_or(NONE, |&cell| cell)
        };
        let ends = [overlay.origins[first as usize], overlay.destination(last)];
        self.origins.extend(ends);
        self.cells.extend([cell_of(first), cell_of(twin(first))]);
        self.kinds.push(kind.get());
        self.advances.push(advance);
        self.paths.push((start, self.path_nodes.len() as u32));
        last
    }

    /// The number of darts, those taken away included.
    pub(super) fn dart_count(&self) -> u32 {
        self.origins.len() as u32
    }

    #[inline]
    pub(super) fn is_alive(&self, dart: u32) -> bool {
        self.origins[dart as usize] != NONE
    }

    #[inline]
    pub(super) fn origin(&self, dart: u32) -> u32 {
        self.origins[dart as usize]
    }

    #[inline]
    pub(super) fn destination(&self, dart: u32) -> u32 {
        self.origins[twin(dart) as usize]
    }

    /// Whether the cell to the left is none.
    #[inline]
    pub(super) fn is_outside(&self, dart: u32) -> bool {
        self.cells[dart as usize] == NONE
    }

    /// The darts along the cell of a dart, from it on.
    pub(super) fn around_cell(&self, first: u32) -> impl Iterator<Item = u32> + Clone {
        std::iter::successors(Some(first), move |&dart| {
            Some(self.next[dart as usize]).filter(|&next| next != first)
        })
    }

    /// The darts that leave the origin of a dart, clockwise, from it on.
    pub(super) fn around_node(&self, first: u32) -> impl Iterator<Item = u32> + Clone {
        std::iter::successors(Some(first), move |&dart| {
            Some(self.next[twin(dart) as usize]).filter(|&next| next != first)
        })
    }

    /// The number of sides of the cell to the left, up to 5: nothing depends on more.
    pub(super) fn side_count(&self, dart: u32) -> usize {
        self.around_cell(dart).take(5).count()
    }

    /// The overlay's nodes inside an arc, in the direction of its even dart.
    pub(super) fn path(&self, arc: usize) -> &[u32] {
        let (start, end) = self.paths[arc];
        &self.path_nodes[start as usize..end as usize]
    }

    fn link(&mut self, dart: u32, next: u32) {
        self.next[dart as usize] = next;
        self.previous[next as usize] = dart;
    }

    fn take_away(&mut self, dart: u32) {
        self.origins[dart as usize] = NONE;
        self.origins[twin(dart) as usize] = NONE;
    }

    /// Puts a node of its path into an arc; returns the dart from that node on.
    pub(super) fn split(&mut self, arc: usize, place: usize) -> u32 {
        let dart = 2 * arc as u32;
        let (start, end) = self.paths[arc];
        let middle = start + place as u32;
        let node = self.path_nodes[middle as usize];
        let new = self.dart_count();
        self.origins
            .extend([node, self.origins[twin(dart) as usize]]);
        self.next.extend([NONE; 2]);
        self.previous.extend([NONE; 2]);
        self.cells
            .extend_from_within(dart as usize..dart as usize + 2);
        self.kinds.push(self.kinds[arc]);
        self.advances.push(f64::NAN);
        self.advances[arc] = f64::NAN;
        self.paths[arc] = (start, middle);
        self.paths.push((middle + 1, end));
        let after = self.next[dart as usize];
        let before = self.previous[twin(dart) as usize];
        self.origins[twin(dart) as usize] = node;
        self.link(
            new,
            if after == twin(dart) {
                twin(new)
            } else {
                after
            },
        );
        self.link(if before == dart { new } else { before }, twin(new));
        self.link(dart, new);
        self.link(twin(new), twin(dart));
        new
    }

    /// Takes an arc away, so that the cell to the right of the dart is joined to that on the left.
    /// The two must differ.
    pub(super) fn remove(&mut self, dart: u32) {
        let other = twin(dart);
        let cell = self.cells[dart as usize];
        for beyond in self.around_cell(other).collect::<Vec<_>>() {
            self.cells[beyond as usize] = cell;
        }
        let [before, after] = [self.previous[dart as usize], self.next[dart as usize]];
        let [other_before, other_after] =
            [self.previous[other as usize], self.next[other as usize]];
        self.link(before, other_after);
        self.link(other_before, after);
        self.take_away(dart);
    }

    /// Draws the arc of a dart together: its end goes over to its origin.
    pub(super) fn contract(&mut self, dart: u32) {
        let (origin, other) = (self.origin(dart), twin(dart));
        for leaving in self.around_node(other).collect::<Vec<_>>() {
            self.origins[leaving as usize] = origin;
        }
        let [before, after] = [self.previous[dart as usize], self.next[dart as usize]];
        let [other_before, other_after] =
            [self.previous[other as usize], self.next[other as usize]];
        self.link(before, after);
        self.link(other_before, other_after);
        self.take_away(dart);
    }

    /// Joins the two arcs that meet at the origin of a dart, which must have no other.
    pub(super) fn dissolve(&mut self, dart: u32) {
        // ... before -> node -> dart ...
        let before = self.previous[dart as usize];
        let path = |this: &Self, dart: u32| -> Vec<u32> {
            let mut path = this.path(arc(dart)).to_vec();
            if dart % 2 == 1 {
                path.reverse();
            }
            path
        };
        let mut joined = path(self, before);
        joined.push(self.origin(dart));
        joined.extend(path(self, dart));
        if before % 2 == 1 {
            joined.reverse();
        }
        let start = self.path_nodes.len() as u32;
        self.path_nodes.extend(joined);
        self.paths[arc(before)] = (start, self.path_nodes.len() as u32);
        self.advances[arc(before)] += self.advances[arc(dart)];
        self.origins[twin(before) as usize] = self.destination(dart);
        let [after, other_before] = [self.next[dart as usize], self.previous[twin(dart) as usize]];
        self.link(before, after);
        self.link(other_before, twin(before));
        self.take_away(dart);
    }
}

/// What a chain of pieces is for the most part: where a feature ends between two lattice points, the
/// line goes on.
#[derive(Default)]
struct LongestKind(Vec<(ArcKind, f64)>);

impl LongestKind {
    fn add(&mut self, overlay: &Overlay, dart: u32) {
        let ends = [overlay.origins[dart as usize], overlay.destination(dart)];
        let [from, to] = ends.map(|node| overlay.positions[node as usize]);
        let (kind, length) = (overlay.kinds[arc(dart)], from.distance(to));
        match self.0.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, sum)) => *sum += length,
            None => self.0.push((kind, length)),
        }
    }

    fn get(&self) -> ArcKind {
        let longest = self.0.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        longest.map_or(ArcKind::Line, |&(kind, _)| kind)
    }
}

/// The nodes that end arcs: where three or more pieces of the net meet, lattice points, and three
/// on each closed line without any.
fn corners(overlay: &Overlay) -> Vec<bool> {
    let degrees = overlay.degrees();
    let mut corners: Vec<bool> = (degrees.iter().zip(&overlay.lattice))
        .map(|(&degree, &lattice)| degree > 2 || degree == 2 && lattice)
        .collect();
    let mut visited = vec![false; overlay.origins.len()];
    // All that a corner can be reached from along the net.
    for first in overlay.darts() {
        if !corners[overlay.origins[first as usize] as usize] || !overlay.is_drawn(first) {
            continue;
        }
        let mut dart = first;
        loop {
            visited[dart as usize] = true;
            visited[twin(dart) as usize] = true;
            if corners[overlay.destination(dart) as usize] {
                break;
            }
            dart = overlay.next_drawn(dart);
        }
    }
    for first in overlay.darts() {
        if visited[first as usize] || !overlay.is_drawn(first) {
            continue;
        }
        let ring: Vec<u32> = std::iter::successors(Some(first), |&dart| {
            Some(overlay.next_drawn(dart)).filter(|&next| next != first)
        })
        .collect();
        for &dart in &ring {
            visited[dart as usize] = true;
            visited[twin(dart) as usize] = true;
        }
        for third in 0..3 {
            let dart = ring[third * ring.len() / 3];
            corners[overlay.origins[dart as usize] as usize] = true;
        }
    }
    corners
}
