//! A mesh of the right topology brought to a tolerance: with less of it where that is
//! not kept, and cut up where it would run through itself or face into the solid.

use crate::clock::Instant;

use rustc_hash::FxHashMap;

use super::{PARTED, REFINED, Run, SHAPED};
use crate::arrangement::Borders;
use crate::error::Error;
use crate::limits::Demand;
use crate::mesh::{Mesh, MeshSurface};
use crate::mesher::fit::{HALVINGS, fit, is_too_much};
use crate::program::{Program, SurfaceId};
use crate::report::Report;
use crate::task::Task;
use crate::tessellate::{self, Goal, Outcome, Parting, Refined, Separation, Surfaced};

/// So many times as many triangles are not worth it that a mesh does not run through itself.
const MOST_GROWTH: usize = 20;

/// Of what follows once all parts were refined, that share is the check of all of them, about.
const CHECKED: f64 = 0.7;

impl Run<'_> {
    /// Brings a mesh in the task's frame to the tolerance, or to a larger one if
    /// only that fits the limits. On other borders of looks than these, within one
    /// surface, no curve is known.
    pub(super) fn refine(
        &self,
        mesh: &mut Mesh,
        borders: Borders,
        task: &Task<'_>,
        goal: &Goal,
        report: &mut Report,
    ) -> Result<(), Error> {
        let start = Instant::now();
        merge_alike(mesh, task.program);
        let precision = tessellate::precision(&mesh.positions);
        let coarse = Surfaced {
            precision,
            reach: task.size.length(),
            positions: std::mem::take(&mut mesh.positions),
            triangles: std::mem::take(&mut mesh.triangles),
            groups: std::mem::take(&mut mesh.triangle_surfaces),
            surface_of_group: mesh.surfaces.iter().map(|s| SurfaceId(s.surface)).collect(),
            borders,
        };
        let asked = goal.tolerance;
        let most = if self.mesher.limits.partial {
            task.size.length().max(asked)
        } else {
            asked
        };
        let (refined, reached) = fit(asked, most, HALVINGS, |tolerance| {
            self.refine_to(&coarse, task, &goal.loosened(tolerance / asked))
        })?;
        let Surfaced {
            positions,
            triangles,
            groups,
            ..
        } = refined.surfaced;
        mesh.positions = positions;
        mesh.triangles = triangles;
        mesh.triangle_surfaces = groups;
        let outcome = refined.outcome;
        report.deviation = Some(outcome.deviation);
        report.farthest = Some(outcome.farthest + task.origin);
        for (reason, place) in outcome.unkept {
            report.add_fallback(reason.describe(), place + task.origin);
        }
        report.limits_reached.extend(reached);
        report.end_stage("refine", start);
        Ok(())
    }

    /// Brings each part of a mesh to the tolerance, and those once more and together that
    /// break it, run through each other or are folded.
    fn refine_to(&self, coarse: &Surfaced, task: &Task<'_>, goal: &Goal) -> Result<Refined, Error> {
        let parts = tessellate::parts(coarse);
        let parts = parts.as_deref().unwrap_or(std::slice::from_ref(coarse));
        let alone = self.refine_each(parts, task, goal)?;
        let is_narrow = |part: &Refined| !part.outcome.tighter.is_empty();
        let mut is_wrong: Vec<bool> = alone.iter().map(is_narrow).collect();
        let mut together: Option<Refined> = None;
        if is_wrong.contains(&true) {
            together = Some(self.refine_wrong(parts, &alone, &is_wrong, task, goal)?);
        }
        loop {
            let right = (0..parts.len()).filter(|&part| !is_wrong[part]);
            let all: Vec<&Refined> = right
                .clone()
                .map(|part| &alone[part])
                .chain(&together)
                .collect();
            let whole = tessellate::join_refined(&all);
            if !self.mesher.check {
                return Ok(whole);
            }
            let ends = all.iter().scan(0, |end, part| {
                *end += part.surfaced.triangles.len();
                Some(*end)
            });
            let ends: Vec<usize> = ends.collect();
            let right: Vec<usize> = right.collect();
            let tell = |share: f64| self.tell_of_parting(CHECKED * share);
            let wrong = wrong_triangles(&whole.surfaced, task, &tell)
                .into_iter()
                .flatten();
            self.tell_of_parting(CHECKED);
            let wrong = wrong.map(|triangle| ends.partition_point(|&end| end <= triangle as usize));
            // What is wrong of the others is known, and noted.
            let wrong: Vec<usize> = wrong.filter_map(|part| right.get(part).copied()).collect();
            if wrong.is_empty() {
                return Ok(whole);
            }
            for part in wrong {
                is_wrong[part] = true;
            }
            together = Some(self.refine_wrong(parts, &alone, &is_wrong, task, goal)?);
        }
    }

    /// Brings parts to the tolerance, each for itself.
    fn refine_each(
        &self,
        parts: &[Surfaced],
        task: &Task<'_>,
        goal: &Goal,
    ) -> Result<Vec<Refined>, Error> {
        let demand = Demand::Tolerance(goal.tolerance);
        let control = self.control.again(demand).part(SHAPED, REFINED);
        let refined = tessellate::to_tolerance(parts, &task.surfaces, goal, &control)?;
        control.tell(1.0);
        Ok(refined)
    }

    /// Brings the parts that are wrong to the tolerance together: where they run through
    /// themselves or each other with all vertices where they were before, first, as they hardly
    /// ever did so then.
    fn refine_wrong(
        &self,
        parts: &[Surfaced],
        alone: &[Refined],
        is_wrong: &[bool],
        task: &Task<'_>,
        goal: &Goal,
    ) -> Result<Refined, Error> {
        let wrong = (0..parts.len()).filter(|&part| is_wrong[part]);
        let coarse = tessellate::join(wrong.clone().map(|part| &parts[part]));
        let first: Vec<&Refined> = wrong.map(|part| &alone[part]).collect();
        let first = tessellate::join_refined(&first);
        if self.mesher.check && !wrong_triangles(&first.surfaced, task, &|_| ()).is_empty() {
            let goal = Goal {
                keeps_vertices: true,
                ..goal.clone()
            };
            let kept = match self.refine_all(&coarse, task, &goal) {
                Err(error) if is_too_much(&error).is_some() => None,
                kept => Some(self.refine_together(&coarse, kept?, task, goal)?),
            };
            if let Some(kept) = kept.filter(|kept| kept.outcome.unkept.is_empty()) {
                return Ok(kept);
            }
        }
        self.refine_together(&coarse, first, task, goal.clone())
    }

    /// Brings a mesh to the tolerance, part by part.
    fn refine_all(
        &self,
        coarse: &Surfaced,
        task: &Task<'_>,
        goal: &Goal,
    ) -> Result<Refined, Error> {
        let parts = tessellate::parts(coarse);
        let parts = parts.as_deref().unwrap_or(std::slice::from_ref(coarse));
        let refined = self.refine_each(parts, task, goal)?;
        Ok(tessellate::join_refined(
            &refined.iter().collect::<Vec<_>>(),
        ))
    }

    /// A mesh brought to a tolerance, at first as it is given. Where it breaks that it is brought
    /// to less; where, if the mesh is to be checked, it runs through itself or is folded, its
    /// triangles are cut up.
    fn refine_together(
        &self,
        coarse: &Surfaced,
        first: Refined,
        task: &Task<'_>,
        mut goal: Goal,
    ) -> Result<Refined, Error> {
        const MOST_TRIES: u32 = 8;
        /// Of a mesh that is not checked.
        const FEW_TRIES: u32 = 3;
        /// In a row, that were no better.
        const MOST_IN_VAIN: u32 = 3;
        const FINER: f64 = 0.4;
        /// So that it is enough where curvature differs along a surface.
        const SPARE: f64 = 0.98;
        let finish = |mut refined: Refined, goal: &Goal| {
            let mut share = None;
            if self.mesher.check {
                if let Some(mirrored) = mirrored(&refined, task, goal) {
                    // What is only too far off need be no finer than that says.
                    let finer = SPARE * goal.promised / mirrored.outcome.deviation;
                    share = mirrored
                        .outcome
                        .is_only_far()
                        .then_some(finer.clamp(FINER, 1.0));
                    refined = mirrored;
                }
                let Refined { surfaced, outcome } = &mut refined;
                self.separate(surfaced, outcome, task, goal)?;
            }
            let mut narrow = std::mem::take(&mut refined.outcome.tighter);
            narrow.sort_unstable();
            narrow.dedup();
            Ok::<_, Error>((refined, narrow, share))
        };
        let (mut best, mut narrow, mut share) = finish(first, &goal)?;
        let most_triangles = MOST_GROWTH * best.surfaced.triangles.len();
        let mut in_vain = 0;
        // At first it may be enough that no vertex of the surfaces is removed.
        let (tries, most_in_vain, at_first) = if self.mesher.check {
            (MOST_TRIES, MOST_IN_VAIN, 1.0)
        } else {
            (FEW_TRIES, 1, FINER)
        };
        for round in 1..tries {
            let done = f64::from(round) / f64::from(tries);
            self.tell_of_parting(CHECKED + (1.0 - CHECKED) * done);
            // What runs through itself still is better cut up in another way.
            if narrow.is_empty() || in_vain == most_in_vain || best.outcome.is_crossed() {
                break;
            }
            for &surface in &narrow {
                let tight = goal.tight.entry(surface);
                tight
                    .and_modify(|known| *known *= share.unwrap_or(FINER))
                    .or_insert(share.unwrap_or(at_first));
            }
            let refined = match self.refine_all(coarse, task, &goal) {
                // Better one that runs through itself than none.
                Err(error) if is_too_much(&error).is_some() => break,
                refined => finish(refined?, &goal)?,
            };
            (narrow, share) = (refined.1, refined.2);
            in_vain += 1;
            let is_too_large = refined.0.surfaced.triangles.len() > most_triangles;
            if refined.0.outcome.unkept.len() < best.outcome.unkept.len() {
                best = refined.0;
                in_vain = 0;
            }
            if is_too_large {
                break;
            }
        }
        Ok(best)
    }

    /// Tells what share is done of what follows once all parts were refined.
    fn tell_of_parting(&self, share: f64) {
        self.control.tell(REFINED + (PARTED - REFINED) * share);
    }

    /// Cuts up the triangles of a mesh that run through each other, or face into the
    /// solid, until none do or that does not help, and notes where they still do.
    fn separate(
        &self,
        surfaced: &mut Surfaced,
        outcome: &mut Outcome,
        task: &Task<'_>,
        goal: &Goal,
    ) -> Result<(), Error> {
        const MOST_ROUNDS: u32 = 14;
        let most_triangles = MOST_GROWTH * surfaced.triangles.len();
        let noted = outcome.clone();
        let before = Separation::new(surfaced, &task.surfaces, goal, noted, task.origin);
        // (What is not manifold is reported as such.)
        let Some(before) = before else {
            return Ok(());
        };
        let mut wrong = before.wrong();
        if wrong.is_empty() {
            return Ok(());
        }
        // Where the mesh is folded there are more and more.
        let too_many = 4 * wrong.len() + 16;
        let mut least = (wrong.len(), before.clone());
        for parting in [Parting::Farthest, Parting::Beside] {
            let mut separation = before.clone();
            wrong = separation.wrong();
            for round in 0..MOST_ROUNDS {
                self.control.check()?;
                self.tell_of_parting(CHECKED * f64::from(round) / f64::from(MOST_ROUNDS));
                if !separation.cut(&wrong, parting) {
                    break;
                }
                wrong = separation.wrong();
                if wrong.len() < least.0 {
                    least = (wrong.len(), separation.clone());
                }
                let is_too_large = separation.triangle_count() > most_triangles;
                if wrong.is_empty() || wrong.len() > too_many || is_too_large {
                    break;
                }
            }
            if least.0 == 0 {
                break;
            }
        }
        *outcome = least.1.finish(surfaced);
        Ok(())
    }
}

/// Makes one entry of those of a mesh's surfaces that only differ in which of
/// several primitives of the same kind, name and colour they come from: borders
/// between them on one surface would keep vertices that nobody needs.
fn merge_alike(mesh: &mut Mesh, program: &Program) {
    let origin = |entry: &MeshSurface| &program.origins()[entry.primitive as usize];
    let mut kept: Vec<MeshSurface> = Vec::new();
    let mut of_surface: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
    let mut merged = Vec::with_capacity(mesh.surfaces.len());
    for entry in &mesh.surfaces {
        let known = of_surface.entry(entry.surface).or_default();
        let alike = known
            .iter()
            .find(|&&k| origin(&kept[k as usize]).looks_like(origin(entry)));
        merged.push(alike.copied().unwrap_or_else(|| {
            kept.push(entry.clone());
            known.push(kept.len() as u32 - 1);
            kept.len() as u32 - 1
        }));
    }
    for index in &mut mesh.triangle_surfaces {
        *index = merged[*index as usize];
    }
    mesh.surfaces = kept;
}

/// The same with faces as images of others, if fewer of its triangles run through each other so.
fn mirrored(refined: &Refined, task: &Task<'_>, goal: &Goal) -> Option<Refined> {
    let wrong = wrong_triangles(&refined.surfaced, task, &|_| ());
    let mirrored = tessellate::mirrored(refined, &task.surfaces, goal, &wrong)?;
    let left = wrong_triangles(&mirrored.surfaced, task, &|_| ());
    (left.len() < wrong.len()).then_some(mirrored)
}

/// The pairs of triangles that run through each other once a mesh's points are
/// about the true origin, as rounding decides where faces meet in a plane; and twice
/// each that faces into the solid. Tells what share of it is done.
fn wrong_triangles(
    surfaced: &Surfaced,
    task: &Task<'_>,
    tell: &(impl Fn(f64) + Sync),
) -> Vec<[u32; 2]> {
    /// All but the search for those that face into the solid.
    const CROSSED: f64 = 0.9;
    let positions = surfaced.positions.iter();
    let mesh = Mesh {
        positions: positions.map(|&p| p + task.origin).collect(),
        triangles: surfaced.triangles.clone(),
        ..Mesh::default()
    };
    let (mut wrong, folded) = rayon::join(
        || mesh.self_intersections_told(&|share| tell(CROSSED * share)),
        || tessellate::folded(surfaced, &task.surfaces),
    );
    wrong.extend(folded.into_iter().map(|triangle| [triangle; 2]));
    wrong
}
