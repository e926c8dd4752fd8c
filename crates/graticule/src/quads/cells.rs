use super::overlay::{ArcKind, NONE, Overlay, arc, twin};
use super::split::Splitter;
use crate::mesh::disjoint_sets::{DisjointSets, number_names};
use crate::tolerance::{BULGING_CELL, FEWEST_PARTS, SPLIT_CELL_AREA};
use crate::watch::{Stopped, Watch};

/// The cells of the net: for each face of the overlay the one that it belongs to.
pub(super) struct Cells {
    pub(super) of_face: Vec<u32>,
    /// How many pieces of lines were taken away because they ended inside a cell.
    pub(super) pruned: usize,
    /// How many cells were cut up because they were no disks or stood out too far.
    pub(super) split: usize,
}

impl Cells {
    /// Takes dangling lines away and cuts cells until each is a disk whose border passes no node
    /// twice.
    pub(super) fn settle(
        overlay: &mut Overlay,
        cell_area: f64,
        watch: &Watch,
    ) -> Result<Self, Stopped> {
        let mut pruned = prune(overlay);
        let (mut of_face, mut count) = join_faces(overlay);
        let mut census = Census::of(overlay, &of_face, count, cell_area);
        while census.has_poor() {
            let erased = erase_islands(overlay, &of_face, &census, cell_area);
            if erased == 0 {
                break;
            }
            pruned += erased;
            (of_face, count) = join_faces(overlay);
            census = Census::of(overlay, &of_face, count, cell_area);
        }
        let split = census.poor.iter().filter(|&&poor| poor).count();
        if split > 0 {
            cut_up(overlay, &of_face, &census, cell_area, watch)?;
            of_face = join_faces(overlay).0;
        }
        Ok(Self {
            of_face,
            pruned,
            split,
        })
    }
}

/// Takes lines away that end inside a cell ([PGP06] §3.3: "nibbled" until another line is met), and
/// returns of how many pieces they were.
///
/// [PGP06]: crate::papers::PGP06
pub(super) fn prune(overlay: &mut Overlay) -> usize {
    let mut degrees = overlay.degrees();
    let mut ends: Vec<u32> = (overlay.darts())
        .filter(|&dart| overlay.is_drawn(dart))
        .filter(|&dart| degrees[overlay.origins[dart as usize] as usize] == 1)
        .collect();
    let mut pruned = 0;
    while let Some(dart) = ends.pop() {
        if !overlay.is_drawn(dart) {
            continue;
        }
        // All others at the far node are found by turning about it.
        let far = overlay.destination(dart);
        let next = overlay.next_drawn(dart);
        overlay.kinds[arc(dart)] = ArcKind::Inner;
        pruned += 1;
        degrees[overlay.origins[dart as usize] as usize] -= 1;
        degrees[far as usize] -= 1;
        if degrees[far as usize] == 1 && next != twin(dart) {
            ends.push(next);
        }
    }
    pruned
}

/// For each face of the overlay the number of its cell, and how many cells there are.
pub(super) fn join_faces(overlay: &Overlay) -> (Vec<u32>, usize) {
    let mut sets = DisjointSets::new(overlay.face_count);
    for dart in overlay.darts().step_by(2) {
        if !overlay.is_drawn(dart) {
            let [one, other] = [dart, twin(dart)].map(|dart| overlay.faces[dart as usize]);
            sets.join(one, other);
        }
    }
    let mut names = sets.into_names();
    let count = number_names(&mut names);
    (names, count)
}

/// What is known of each cell.
pub(super) struct Census {
    /// Vertices less arcs plus faces inside: 1 for a disk.
    euler: Vec<i64>,
    areas: Vec<f64>,
    /// Which cells are no disks, pass a node twice, or stand out so far that their border does not
    /// show them.
    pub(super) poor: Vec<bool>,
}

impl Census {
    pub(super) fn of(overlay: &Overlay, of_face: &[u32], count: usize, cell_area: f64) -> Self {
        let euler = euler_characteristics(overlay, of_face, count);
        let areas = cell_areas(overlay, of_face, count);
        let mut poor: Vec<bool> = euler.iter().map(|&euler| euler != 1).collect();
        let mut visited = vec![false; overlay.origins.len()];
        let mut stamps = vec![NONE; overlay.points.len()];
        for first in overlay.darts() {
            let face = overlay.faces[first as usize];
            if face == NONE || visited[first as usize] || !overlay.is_drawn(first) {
                continue;
            }
            let cell = of_face[face as usize] as usize;
            let walk = || walk_cell(overlay, first);
            for dart in walk() {
                visited[dart as usize] = true;
                let stamp = &mut stamps[overlay.origins[dart as usize] as usize];
                poor[cell] |= *stamp == first;
                *stamp = first;
            }
            if areas[cell] > cell_area / 2.0 {
                poor[cell] |= areas[cell] > BULGING_CELL * overlay.area_vector(walk()).length();
            }
        }
        Self { euler, areas, poor }
    }

    pub(super) fn has_poor(&self) -> bool {
        self.poor.contains(&true)
    }

    /// Area up to which the parts of a poor cell are joined: parts of limbs are kept small enough to
    /// show their shape.
    fn part_limit(&self, cell: u32, cell_area: f64) -> f64 {
        let usual = SPLIT_CELL_AREA * cell_area;
        let area = self.areas[cell as usize];
        if self.euler[cell as usize] == 1 && area < BULGING_CELL * cell_area {
            usual
        } else {
            usual.min(area / FEWEST_PARTS)
        }
    }
}

/// Takes islands of the net away, which lie in a cell without touching its border, where all they
/// surround is smaller than a cell: the map folds there. Returns of how many pieces they were.
fn erase_islands(overlay: &mut Overlay, of_face: &[u32], census: &Census, cell_area: f64) -> usize {
    let mut sets = DisjointSets::new(overlay.points.len());
    for dart in overlay
        .darts()
        .step_by(2)
        .filter(|&dart| overlay.is_drawn(dart))
    {
        sets.join(overlay.origins[dart as usize], overlay.destination(dart));
    }
    let islands = sets.into_names();
    let mut shores = vec![Shore::default(); islands.len()];
    let mut seen: Vec<(u32, u32)> = Vec::new();
    let mut counted = vec![false; islands.len()];
    for dart in overlay.darts().filter(|&dart| overlay.is_drawn(dart)) {
        let node = overlay.origins[dart as usize] as usize;
        let island = islands[node];
        let shore = &mut shores[island as usize];
        if dart.is_multiple_of(2) {
            shore.euler -= 1;
        }
        if !counted[node] {
            counted[node] = true;
            shore.euler += 1;
        }
        shore.fixed |= overlay.kinds[arc(dart)] > ArcKind::Line;
        match of_face.get(overlay.faces[dart as usize] as usize) {
            Some(&cell) => seen.push((island, cell)),
            None => shore.fixed = true,
        }
    }
    seen.sort_unstable();
    seen.dedup();
    for (island, cell) in seen {
        let shore = &mut shores[island as usize];
        if census.euler[cell as usize] == 1 {
            shore.euler += 1;
            shore.area += census.areas[cell as usize];
        } else {
            shore.open_cells += 1;
        }
    }
    let erase = |shore: &Shore| {
        !shore.fixed && shore.euler == 1 && shore.open_cells == 1 && shore.area < cell_area
    };
    let mut erased = 0;
    for dart in overlay.darts().step_by(2) {
        let island = islands[overlay.origins[dart as usize] as usize] as usize;
        if overlay.is_drawn(dart) && erase(&shores[island]) {
            overlay.kinds[arc(dart)] = ArcKind::Inner;
            erased += 1;
        }
    }
    erased
}

/// A connected part of the net and the cells that it touches.
#[derive(Clone, Copy, Default)]
struct Shore {
    /// Nodes less arcs plus cells that are disks.
    euler: i64,
    /// The area of those cells.
    area: f64,
    /// How many cells it touches that are no disks.
    open_cells: usize,
    /// Whether there is a part of the boundary or of a feature in it.
    fixed: bool,
}

/// The darts of the net along a cell, from `first` on.
fn walk_cell(overlay: &Overlay, first: u32) -> impl Iterator<Item = u32> + Clone {
    std::iter::successors(Some(first), move |&dart| {
        Some(overlay.next_drawn(dart)).filter(|&next| next != first)
    })
}

/// Vertices less arcs plus faces inside each cell: 1 for a disk.
fn euler_characteristics(overlay: &Overlay, of_face: &[u32], count: usize) -> Vec<i64> {
    let mut euler = vec![0_i64; count];
    for &cell in of_face {
        euler[cell as usize] += 1;
    }
    let mut counted: Vec<bool> = overlay.degrees().iter().map(|&degree| degree > 0).collect();
    for dart in overlay.darts().filter(|&dart| !overlay.is_drawn(dart)) {
        let cell = of_face[overlay.faces[dart as usize] as usize] as usize;
        if dart.is_multiple_of(2) {
            euler[cell] -= 1;
        }
        let node = overlay.origins[dart as usize] as usize;
        if !counted[node] {
            counted[node] = true;
            euler[cell] += 1;
        }
    }
    euler
}

fn cell_areas(overlay: &Overlay, of_face: &[u32], count: usize) -> Vec<f64> {
    let mut areas = vec![0.0; count];
    for (face, area) in face_areas(overlay).into_iter().enumerate() {
        areas[of_face[face] as usize] += area;
    }
    areas
}

/// The area of each face of the overlay; faces are flat.
fn face_areas(overlay: &Overlay) -> Vec<f64> {
    first_darts(overlay)
        .into_iter()
        .map(|first| overlay.area_vector(face_walk(overlay, first)).length())
        .collect()
}

/// One dart of each face of the overlay.
fn first_darts(overlay: &Overlay) -> Vec<u32> {
    let mut firsts = vec![NONE; overlay.face_count];
    for dart in overlay.darts().rev() {
        if let Some(first) = firsts.get_mut(overlay.faces[dart as usize] as usize) {
            *first = dart;
        }
    }
    firsts
}

fn face_walk(overlay: &Overlay, first: u32) -> impl Iterator<Item = u32> + Clone {
    std::iter::successors(Some(first), move |&dart| {
        Some(overlay.next[dart as usize]).filter(|&next| next != first)
    })
}

/// Cuts each poor cell into disks of ordinary size.
fn cut_up(
    overlay: &mut Overlay,
    of_face: &[u32],
    census: &Census,
    cell_area: f64,
    watch: &Watch,
) -> Result<(), Stopped> {
    let firsts = first_darts(overlay);
    let mut faces: Vec<(u32, u32)> = (of_face.iter().enumerate())
        .filter(|&(_, &cell)| census.poor[cell as usize])
        .map(|(face, &cell)| (cell, face as u32))
        .collect();
    faces.sort_unstable();
    let mut splitter = Splitter::new(overlay);
    for cell in faces.chunk_by(|a, b| a.0 == b.0) {
        watch.check()?;
        let limit = census.part_limit(cell[0].0, cell_area);
        let walks = cell.iter().map(|&(_, face)| firsts[face as usize]);
        let walks = walks
            .map(|first| face_walk(overlay, first).collect())
            .collect();
        for cut in splitter.cuts(overlay, walks, limit) {
            overlay.kinds[cut] = ArcKind::Cut;
        }
    }
    Ok(())
}
