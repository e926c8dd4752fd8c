use super::angle_fit::{AngleFit, STIFFENED_SOLVES};
use super::face_path::{End, FacePath, FacePathFinder};
use super::guidance::CURVATURE_WEIGHT;
use super::matching::Matching;
use super::{CrossField, FieldDomain, FieldError, Guidance, Singularity};
use crate::mesh::{Element, FaceId, HalfedgeId, PerComponent, PerFace, Topology, VertexId};
use crate::watch::Watch;

/// Where a field is to be singular.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum SingularityPlan {
    /// Where smoothing leaves it so, close pairs cancelled.
    #[default]
    Found,
    /// In these triangles alone. In each component the indices must sum to the Euler
    /// characteristic, less what the field turns against a boundary that it is held to.
    Given(Vec<Singularity>),
    /// As found, but with the singularity of the first triangle of each pair brought into the
    /// second; onto one of opposite sign, both vanish.
    Moved(Vec<[FaceId; 2]>),
}

/// Singularities for [`FieldDomain::with_singularities`].
#[derive(Clone, Debug, PartialEq)]
pub struct Prescription {
    /// All that the field is to have. Those of one triangle add up.
    pub singularities: Vec<Singularity>,
    /// The share of smoothness against guidance, as in
    /// [`SmoothingOptions`](super::SmoothingOptions).
    pub smoothing: f64,
}

impl FieldDomain<'_> {
    /// The smoothest field that has these singularities and no others, follows its guidance as far
    /// as that lets it, and runs round the handles as `field` does: a trivial connection
    /// (K. Crane, M. Desbrun, P. Schröder, *Trivial Connections on Discrete Surfaces*, 2010) found
    /// from the jumps of a field there is.
    ///
    /// Steps of the index are carried along shortest paths from where `field` has too many of them
    /// to where it has too few, or across a boundary that it is not held to; then the angles are
    /// found for the jumps changed by that. A singularity of more than one step seldom fits into one
    /// triangle: an edge cannot turn by more than half a step.
    ///
    /// Cost: some ten factorisations with a real unknown per free vertex.
    ///
    /// # Errors
    /// [`FieldError::NoSuchFace`], [`FieldError::SingularitySum`], [`FieldError::Enclosed`],
    /// [`FieldError::NotReached`].
    pub fn with_singularities(
        &self,
        field: &CrossField,
        guidance: &Guidance,
        wanted: &Prescription,
        watch: &Watch,
    ) -> Result<CrossField, FieldError> {
        let _stage = watch.stage("prescribed singularities");
        let symmetry = field.symmetry();
        let steps = self.wanted_steps(&wanted.singularities)?;
        let mut matching = Matching::nearest(self, field);
        let mut excess = matching.steps(self, symmetry.step());
        for (excess, wanted) in excess.as_mut_slice().iter_mut().zip(&steps) {
            *excess -= wanted;
        }
        self.check_sums(&excess, &steps, guidance)?;
        self.carry_excess(&mut matching, excess, guidance, watch)?;
        let mut angles = field.angles().clone();
        let is_free = |vertex: &VertexId| guidance.fixed(*vertex).is_none();
        let free: Vec<VertexId> = self.surface().mesh().vertices().filter(is_free).collect();
        if !free.is_empty() {
            let mut fit = AngleFit::new(self, guidance, wanted.smoothing);
            fit.fit(&mut angles, &matching, &free, STIFFENED_SOLVES)?;
        }
        let angles = angles.map(|&angle| symmetry.reduce(angle).0);
        let field = CrossField::from_angles(symmetry, angles);
        self.check_reached(&field, &steps)?;
        Ok(field)
    }

    /// The steps wanted in each triangle.
    fn wanted_steps(&self, wanted: &[Singularity]) -> Result<PerFace<i32>, FieldError> {
        let count = self.surface().mesh().face_count();
        let mut steps = PerFace::filled(count, 0);
        for singularity in wanted {
            self.check_face(singularity.face)?;
            steps[singularity.face] += singularity.steps;
        }
        Ok(steps)
    }

    pub(super) fn check_face(&self, face: FaceId) -> Result<(), FieldError> {
        let count = self.surface().mesh().face_count();
        if face.index() < count {
            Ok(())
        } else {
            Err(FieldError::NoSuchFace { face, count })
        }
    }

    /// Refuses what no path could mend: a component without open boundary that has more steps, or
    /// fewer, than are wanted there.
    fn check_sums(
        &self,
        excess: &PerFace<i32>,
        wanted: &PerFace<i32>,
        guidance: &Guidance,
    ) -> Result<(), FieldError> {
        let mesh = self.surface().mesh();
        let topology = Topology::of(mesh);
        let count = topology.components.len();
        let [mut sums, mut wishes] = [0, 1].map(|_| PerComponent::filled(count, 0));
        let mut is_open = PerComponent::filled(count, false);
        for (face, &excess) in excess.enumerate() {
            let component = topology.face_components[face];
            sums[component] += excess;
            wishes[component] += wanted[face];
            is_open[component] |=
                (face.halfedges().iter()).any(|&halfedge| self.is_open_rim(halfedge, guidance));
        }
        let order = f64::from(guidance.symmetry().order());
        let wrong = sums
            .enumerate()
            .find(|&(component, &sum)| sum != 0 && !is_open[component]);
        wrong.map_or(Ok(()), |(component, &sum)| {
            let wish = wishes[component];
            Err(FieldError::SingularitySum {
                component: component.index(),
                sum: f64::from(wish) / order,
                needed: f64::from(wish + sum) / order,
            })
        })
    }

    /// Whether the field may turn against the boundary along this halfedge.
    fn is_open_rim(&self, halfedge: HalfedgeId, guidance: &Guidance) -> bool {
        let mesh = self.surface().mesh();
        let is_held = |&vertex: &VertexId| {
            guidance.fixed(vertex).is_some() || guidance.weight(vertex) > CURVATURE_WEIGHT
        };
        mesh.twin(halfedge).is_none() && !mesh.ends(halfedge).iter().all(is_held)
    }

    fn carry_excess(
        &self,
        matching: &mut Matching,
        mut excess: PerFace<i32>,
        guidance: &Guidance,
        watch: &Watch,
    ) -> Result<(), FieldError> {
        let mesh = self.surface().mesh();
        let mut finder = FacePathFinder::new(self.surface());
        let faces: Vec<FaceId> = (excess.enumerate())
            .filter(|&(_, &excess)| excess != 0)
            .map(|(face, _)| face)
            .collect();
        // Where there are too many steps first; then only the boundary can bring what is missing.
        for sign in [1, -1] {
            for &face in &faces {
                while excess[face] * sign > 0 {
                    watch.check()?;
                    let path = self.path_from(face, &excess, guidance, &mut finder);
                    let path = path.ok_or(FieldError::Enclosed { face })?;
                    matching.carry(mesh, &path.crossed, sign);
                    excess[face] -= sign;
                    if let End::Face(other) = path.end {
                        excess[other] += sign;
                    }
                }
            }
        }
        Ok(())
    }

    /// The shortest way to a triangle with the opposite excess, or out.
    fn path_from(
        &self,
        face: FaceId,
        excess: &PerFace<i32>,
        guidance: &Guidance,
        finder: &mut FacePathFinder<'_>,
    ) -> Option<FacePath> {
        let mesh = self.surface().mesh();
        let is_open = |halfedge: HalfedgeId| match mesh.twin(halfedge) {
            None => self.is_open_rim(halfedge, guidance),
            Some(_) => !guidance.holds_ends(mesh, halfedge),
        };
        let is_end = |end| match end {
            End::Face(other) => excess[other] * excess[face] < 0,
            End::Rim(_) => true,
        };
        finder.nearest(face, f64::INFINITY, is_open, is_end)
    }

    fn check_reached(&self, field: &CrossField, wanted: &PerFace<i32>) -> Result<(), FieldError> {
        let found = self.singularities(field);
        let mut steps = PerFace::filled(wanted.len(), 0);
        for singularity in &found.faces {
            steps[singularity.face] = singularity.steps;
        }
        let wrong = wanted
            .enumerate()
            .find(|&(face, &wanted)| steps[face] != wanted);
        wrong.map_or(Ok(()), |(face, &wanted)| {
            let order = f64::from(field.symmetry().order());
            Err(FieldError::NotReached {
                face,
                wanted: f64::from(wanted) / order,
                found: f64::from(steps[face]) / order,
            })
        })
    }

    /// What a field that is singular as `found` becomes with some singularities moved.
    ///
    /// # Errors
    /// [`FieldError::NoSuchFace`], [`FieldError::NotSingular`].
    pub fn moved_singularities(
        &self,
        found: &[Singularity],
        moves: &[[FaceId; 2]],
    ) -> Result<Vec<Singularity>, FieldError> {
        let mut steps = self.wanted_steps(found)?;
        for &[from, to] in moves {
            self.check_face(from)?;
            self.check_face(to)?;
            let taken = std::mem::take(&mut steps[from]);
            if taken == 0 {
                return Err(FieldError::NotSingular { face: from });
            }
            steps[to] += taken;
        }
        let singular = steps.enumerate().filter(|&(_, &steps)| steps != 0);
        Ok(singular
            .map(|(face, &steps)| Singularity { face, steps })
            .collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{
        FieldOptions, FieldResult, Guide, GuidePlace, Strength, Symmetry, cross_field,
    };
    use crate::mesh::Surface;
    use graticule_fixtures::{Fixture, cube, disk, icosphere, torus};

    fn surface(fixture: Fixture) -> Surface {
        Surface::from_triangles(fixture.positions, &fixture.triangles).unwrap()
    }

    fn with_plan(
        surface: &Surface,
        symmetry: Symmetry,
        plan: SingularityPlan,
    ) -> Result<FieldResult, FieldError> {
        let options = FieldOptions {
            symmetry,
            singularities: plan,
            ..FieldOptions::default()
        };
        cross_field(surface, &options, &Watch::new())
    }

    fn given(list: &[(u32, i32)]) -> SingularityPlan {
        let singular = list.iter().map(|&(face, steps)| Singularity {
            face: FaceId(face),
            steps,
        });
        SingularityPlan::Given(singular.collect())
    }

    fn found(result: &FieldResult) -> Vec<(u32, i32)> {
        let faces = result.singularities.faces.iter();
        faces.map(|s| (s.face.0, s.steps)).collect()
    }

    #[test]
    fn prescribed_singularities_are_the_only_ones() {
        let sphere = surface(icosphere(3));
        let all: Vec<(u32, i32)> = (0..8).map(|k| (7 + 150 * k, 1)).collect();
        let more: Vec<(u32, i32)> = (0..8)
            .map(|k| (7 + 150 * k, 1))
            .chain([(60, 1), (1000, -1)])
            .collect();
        for mut list in [all, more] {
            let result = with_plan(&sphere, Symmetry::Cross, given(&list)).unwrap();
            list.sort_unstable();
            assert_eq!(found(&result), list);
        }
        for (symmetry, list) in [
            (Symmetry::Line, vec![(3, 1), (300, 1), (600, 1), (900, 1)]),
            (Symmetry::Vector, vec![(3, 1), (900, 1)]),
        ] {
            let result = with_plan(&sphere, symmetry, given(&list)).unwrap();
            assert_eq!(found(&result), list);
        }
    }

    #[test]
    fn surfaces_with_handles_and_boundary_take_prescriptions() {
        let torus = surface(torus(2.0, 0.7, 40, 16));
        let pair = [(100, 1), (700, -1)];
        let result = with_plan(&torus, Symmetry::Cross, given(&pair)).unwrap();
        assert_eq!(found(&result), pair);
        let result = with_plan(&torus, Symmetry::Cross, given(&[])).unwrap();
        assert_eq!(result.report.singularities, 0);
        let disk = surface(disk(16));
        let middle = [(0, 1), (200, 1), (500, 1), (900, 1)];
        let result = with_plan(&disk, Symmetry::Cross, given(&middle)).unwrap();
        assert_eq!(found(&result), middle);
    }

    #[test]
    fn a_free_boundary_takes_what_is_left() {
        let disk = surface(disk(12));
        let options = FieldOptions {
            boundary: None,
            singularities: given(&[(100, 1)]),
            ..FieldOptions::default()
        };
        let result = cross_field(&disk, &options, &Watch::new()).unwrap();
        assert_eq!(found(&result), [(100, 1)]);
        assert!((result.report.index_sum - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_moved_singularity_is_where_it_was_brought_to() {
        let sphere = surface(icosphere(3));
        let before = with_plan(&sphere, Symmetry::Cross, SingularityPlan::Found).unwrap();
        let mut list = found(&before);
        assert_eq!(list.len(), 8);
        let from = FaceId(list[0].0);
        let neighbours = from
            .halfedges()
            .map(|h| sphere.mesh().twin(h).unwrap().face());
        let to = neighbours[0];
        let moved = SingularityPlan::Moved(vec![[from, to]]);
        let after = with_plan(&sphere, Symmetry::Cross, moved).unwrap();
        list[0] = (to.0, 1);
        list.sort_unstable();
        assert_eq!(found(&after), list);
        let regular = (0..100)
            .map(FaceId)
            .find(|f| list.iter().all(|s| s.0 != f.0));
        let nothing = SingularityPlan::Moved(vec![[regular.unwrap(), to]]);
        assert!(matches!(
            with_plan(&sphere, Symmetry::Cross, nothing),
            Err(FieldError::NotSingular { .. })
        ));
    }

    #[test]
    fn prescriptions_that_cannot_be_are_refused() {
        let sphere = surface(icosphere(2));
        let refusal = with_plan(&sphere, Symmetry::Cross, given(&[(0, 1)])).unwrap_err();
        assert_eq!(
            refusal,
            FieldError::SingularitySum {
                component: 0,
                sum: 0.25,
                needed: 2.0
            }
        );
        let refusal = with_plan(&sphere, Symmetry::Cross, given(&[(99_999, 1)])).unwrap_err();
        assert!(matches!(refusal, FieldError::NoSuchFace { .. }));
        // Eight steps in one triangle: its edges would have to turn by 240° each.
        let refusal = with_plan(&sphere, Symmetry::Cross, given(&[(0, 8)])).unwrap_err();
        assert!(
            matches!(refusal, FieldError::NotReached { .. }),
            "{refusal}"
        );
        // The edges of a box keep what belongs to its corners.
        let block = surface(cube().subdivided().subdivided().subdivided());
        let flat = with_plan(&block, Symmetry::Cross, SingularityPlan::Found).unwrap();
        let mut list = found(&flat);
        list[0].1 = 0;
        let middle = block
            .mesh()
            .faces()
            .find(|&face| {
                let p = block.corner_positions(face).iter().sum::<glam::DVec3>() / 3.0;
                p.x == 0.0 && p.distance(glam::DVec3::new(0.0, 0.5, 0.5)) < 0.1
            })
            .unwrap();
        list.push((middle.0, 1));
        let refusal = with_plan(&block, Symmetry::Cross, given(&list)).unwrap_err();
        assert!(
            matches!(
                refusal,
                FieldError::Enclosed { .. } | FieldError::NotReached { .. }
            ),
            "{refusal}"
        );
    }

    #[test]
    fn guides_are_kept_beside_prescriptions() {
        let torus = surface(torus(2.0, 0.7, 40, 16));
        let pair = [(100, 1), (700, -1)];
        let before = with_plan(&torus, Symmetry::Cross, given(&pair)).unwrap();
        let vertex = VertexId(300);
        let options = FieldOptions {
            singularities: given(&pair),
            guides: vec![Guide {
                place: GuidePlace::Vertex(vertex),
                direction: before.directions[vertex] + 0.2 * before.normals[vertex],
                strength: Strength::Hard,
            }],
            ..FieldOptions::default()
        };
        let after = cross_field(&torus, &options, &Watch::new()).unwrap();
        assert_eq!(found(&after), pair);
        let angle = after.directions[vertex].angle_between(before.directions[vertex]);
        assert!(Symmetry::Cross.reduce(angle).0.abs() < 1e-3, "{angle}");
    }
}
