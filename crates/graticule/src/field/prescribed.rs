use super::angle_fit::AngleFit;
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
            fit.fit(&mut angles, &matching, &free)?;
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
