//! `compare`: how two solids differ, in volume and by distance.

use std::fmt;
use std::path::{Path, PathBuf};

use csg::brep::Bounded;
use csg::glam::DVec3;
use csg::{BoundaryOptions, Brep, Error, Mesh, Mesher, Program, Solid};
use serde::Serialize;

use super::figure::{Figure, at_most, short};
use super::parse::length;
use super::sheet::TellOptions;
use crate::failure::Failure;
use crate::input::{Reading, Subject, Wanted};
use crate::nothing::Nothing;
use crate::output::{self, is_stream};
use crate::progress::Progress;

/// Options of `compare`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// The one: a scene, an OpenSCAD model or a mesh
    #[arg(value_name = "A")]
    one: PathBuf,
    /// The other one
    #[arg(value_name = "B")]
    other: PathBuf,
    #[command(flatten)]
    reading: Reading,
    /// The solids are equal if no point of either boundary is farther than this from the other
    /// one, too, and not only if they have the same points; where that stays open they are not
    /// said to be
    #[arg(long, value_name = "DISTANCE", value_parser = length, allow_negative_numbers = true)]
    within: Option<f64>,
    /// The tolerance of the meshes by which distances are found [default: a twentieth of
    /// --within, or a ten-thousandth of the longest side]
    #[arg(long, value_name = "DISTANCE", value_parser = length, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    #[command(flatten)]
    tell: TellOptions,
}

/// How two solids differ.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Comparison {
    /// Whether they are the same: have the same points, or are as near as was asked for; null where
    /// it is open whether they are as near.
    equal: Option<bool>,
    /// Null where no exact boundary could be told.
    volumes: Option<Volumes>,
    /// The largest distance from a point of one boundary to the other one; null if one has
    /// none.
    distance: Option<Distance>,
    /// A point that one of them has and the other one has not; null if none was found.
    witness: Option<Witness>,
    unit: &'static str,
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Volumes {
    one: Figure,
    other: Figure,
    /// Of what is in the one alone.
    in_one: Figure,
    /// Of what is in the other one alone.
    in_other: Figure,
    /// Of both.
    difference: Figure,
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Distance {
    lower: f64,
    /// Null where the meshes' deviation is not proven.
    upper: Option<f64>,
    /// About where it is found; null where there is none.
    place: Option<[f64; 3]>,
}

impl Distance {
    /// Whether it is no more than another one; none if both are possible.
    fn is_within(&self, within: f64) -> Option<bool> {
        if self.upper.is_some_and(|upper| upper <= within) {
            Some(true)
        } else {
            (self.lower > within).then_some(false)
        }
    }
}

impl Default for Distance {
    fn default() -> Self {
        Self {
            lower: 0.0,
            upper: Some(0.0),
            place: None,
        }
    }
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Witness {
    point: [f64; 3],
    /// The one that has it: "one" or "other".
    inside: &'static str,
}

/// Of the distance within which solids are equal, how far meshes may stray at first: enough where
/// the distance is not just that.
const OF_WITHIN: f64 = 0.05;

/// Compares; whether they are equal.
pub(crate) fn run(options: &Options, progress: &Progress) -> Result<bool, Failure> {
    progress.stage("reading");
    let [one, other] = [&options.one, &options.other].map(|path| Side::read(path, options));
    let [one, other] = [one?, other?];
    progress.stage("volumes");
    let solids = [one.solid.clone(), other.solid.clone()];
    let boundary = BoundaryOptions::new().limits(options.tell.limits.limits());
    let (volumes, witness) = match volumes(&solids, &boundary) {
        Ok((volumes, witness)) => (Some(volumes), witness),
        Err(error @ (Error::Undecided(_) | Error::TooLarge { .. })) => {
            say!("warning: no volumes: {error}");
            (None, None)
        }
        Err(error) => return Err(error.into()),
    };
    if let Some(volumes) = &volumes {
        let of = [
            (&volumes.one, &options.one),
            (&volumes.other, &options.other),
        ];
        for ((volume, path), solid) in of.into_iter().zip(&solids) {
            if volume.is_nothing() {
                say!("{}", Nothing::of(solid).in_file(path));
            }
        }
    }
    let is_same = volumes
        .as_ref()
        .is_some_and(|volumes| volumes.difference.is_nothing());
    progress.stage("distance");
    // (Meshes of the same boundary need not be the same.)
    let distance = if is_same {
        Some(Distance::default())
    } else {
        let tolerance = options
            .tolerance
            .or(options.within.map(|within| OF_WITHIN * within));
        let between = |tolerance: Option<f64>| -> Result<Option<(Distance, Fineness)>, Failure> {
            let sides = [
                Boundary::of(&one, tolerance, options)?,
                Boundary::of(&other, tolerance, options)?,
            ];
            let fineness = Fineness::of(&sides);
            Ok(distance(&sides).map(|distance| (distance, fineness)))
        };
        let mut found = between(tolerance)?;
        // How fine meshes have to be follows from the distance, if nothing is said of it.
        while let Some(finer) = found.as_ref().and_then(|found| finer(found, options)) {
            found = between(Some(finer))?;
        }
        found.map(|(distance, _)| distance)
    };
    progress.end();
    let is_near = match (options.within, &distance) {
        (Some(within), Some(distance)) => distance.is_within(within),
        _ => Some(false),
    };
    let comparison = Comparison {
        equal: if is_same { Some(true) } else { is_near },
        volumes,
        distance,
        witness,
        unit: options.tell.unit.symbol(),
    };
    let equal = comparison.equal == Some(true);
    if let Some(path) = &options.tell.json {
        output::write_json(path, &comparison)?;
        if is_stream(path) {
            return Ok(equal);
        }
    }
    output::print(comparison.to_string().as_bytes())?;
    Ok(equal)
}

/// How fine meshes are that were compared.
struct Fineness {
    triangles: usize,
    tolerance: f64,
}

impl Fineness {
    /// Of those that were made; nothing of what was read.
    fn of(sides: &[Boundary; 2]) -> Self {
        let made = sides.iter().filter(|side| side.tolerance.is_some());
        Self {
            triangles: made.clone().map(|side| side.mesh.triangles.len()).sum(),
            tolerance: made.filter_map(|side| side.tolerance).fold(0.0, f64::max),
        }
    }

    /// The tolerance that takes so many triangles: they grow as it falls.
    fn finest(&self, most: f64) -> f64 {
        self.triangles as f64 * self.tolerance / most
    }
}

/// The tolerance of finer meshes, if none was asked for: where it is still open whether the solids
/// are near enough, or else the distance is not told to a few percent. Not finer than takes
/// seconds.
fn finer((found, fineness): &(Distance, Fineness), options: &Options) -> Option<f64> {
    /// Of the distance, and then of the tolerance before.
    const SHARE: f64 = 0.01;
    const STEP: f64 = 0.2;
    const MOST_TRIANGLES: f64 = 1e5;
    let upper = found.upper?;
    let open = upper - found.lower;
    let is_open = match options.within {
        Some(within) => found.is_within(within).is_none(),
        None => open > 4.0 * SHARE * upper,
    };
    let before = fineness.tolerance;
    // (Little finer tells little more.)
    let is_finer = |tolerance: &f64| *tolerance < 0.5 * before;
    let wanted = Some(SHARE * upper).filter(is_finer);
    let wanted = wanted.unwrap_or(STEP * before);
    let tolerance = Some(wanted.max(fineness.finest(MOST_TRIANGLES)));
    tolerance.filter(|finer| options.tolerance.is_none() && is_open && is_finer(finer))
}

/// One of the two, in the unit that they are compared in.
struct Side {
    solid: Solid,
    /// Its boundary as it was read, where that is a mesh.
    mesh: Option<Mesh>,
}

impl Side {
    fn read(path: &Path, options: &Options) -> Result<Self, Failure> {
        let unit = options.tell.unit;
        let subject = options.reading.read(path, &[], Wanted::solid(unit))?;
        let own = subject.unit(unit);
        if own != unit {
            say!(
                "note: the lengths of {} are converted from {} to {} (--unit)",
                path.display(),
                own.symbol(),
                unit.symbol()
            );
        }
        let solid = subject.solid(unit)?;
        let mesh = match subject {
            // (Parts of objects that meet are within the solid.)
            Subject::Mesh(file) if file.meeting_objects().is_none() => {
                Some(file.in_unit(unit.length_unit()).mesh)
            }
            _ => None,
        };
        Ok(Self { solid, mesh })
    }
}

/// A mesh of a solid's boundary, and how far they are apart, if that is known.
struct Boundary {
    mesh: Mesh,
    deviation: Option<f64>,
    /// That it was made to, if it was made.
    tolerance: Option<f64>,
}

impl Boundary {
    fn of(side: &Side, tolerance: Option<f64>, options: &Options) -> Result<Self, Failure> {
        /// Of the longest side, where nothing else is asked for.
        const FINE: f64 = 1e-4;
        if let Some(mesh) = &side.mesh {
            return Ok(Self {
                mesh: mesh.clone(),
                deviation: Some(0.0),
                tolerance: None,
            });
        }
        let program = Program::lower(&side.solid)?;
        let mut mesher = Mesher::new().limits(options.tell.limits.limits());
        let side = program
            .bounds()?
            .map_or(0.0, |bounds| bounds.size().max_element());
        let tolerance = tolerance.unwrap_or(FINE * side);
        if tolerance > 0.0 {
            mesher = mesher.tolerance(tolerance);
        }
        let meshed = mesher.mesh(&program)?;
        let report = &meshed.report;
        let deviation = match report.method {
            "polyhedral" => Some(report.moved.map_or(0.0, |moved| moved.distance)),
            _ => report.deviation.filter(|_| report.is_proven()),
        };
        Ok(Self {
            mesh: meshed.mesh,
            deviation,
            tolerance: Some(tolerance),
        })
    }
}

/// The larger of the distances both ways.
fn distance([one, other]: &[Boundary; 2]) -> Option<Distance> {
    /// Of the longest side; and of what meshes stray, which is unknown anyway.
    const PRECISION: f64 = 1e-6;
    const SHARE: f64 = 0.2;
    let (low, high) = one.mesh.bounds()?;
    let off = one.deviation.zip(other.deviation).map(|(a, b)| a + b);
    let precision = (PRECISION * (high - low).max_element()).max(SHARE * off.unwrap_or(0.0));
    let ways = [
        one.mesh.distance_to(&other.mesh, precision)?,
        other.mesh.distance_to(&one.mesh, precision)?,
    ];
    let farther = ways[usize::from(ways[1].lower > ways[0].lower)];
    let upper = ways[0].upper.max(ways[1].upper);
    Some(Distance {
        lower: (farther.lower - off.unwrap_or(f64::INFINITY)).max(0.0),
        upper: off.map(|off| upper + off),
        place: Some(farther.place.to_array()),
    })
}

fn volumes(
    [one, other]: &[Solid; 2],
    options: &BoundaryOptions,
) -> Result<(Volumes, Option<Witness>), Error> {
    let evaluated = |solid: &Solid| -> Result<(Program, Brep), Error> {
        let program = Program::lower(solid)?;
        let brep = program.boundary(options)?;
        Ok((program, brep))
    };
    let volume = |brep: &Brep| brep.measure().volume;
    let own = [volume(&evaluated(one)?.1), volume(&evaluated(other)?.1)];
    let alone = [evaluated(&(one - other))?, evaluated(&(other - one))?];
    let rest = [volume(&alone[0].1), volume(&alone[1].1)];
    let difference = Bounded {
        value: rest[0].value + rest[1].value,
        error: rest[0].error + rest[1].error,
    };
    let larger = usize::from(rest[1].value > rest[0].value);
    let witness = [larger, 1 - larger].into_iter().find_map(|k| {
        let (program, brep) = &alone[k];
        Some(Witness {
            point: inside(program, brep)?.to_array(),
            inside: ["one", "other"][k],
        })
    });
    let volumes = Volumes {
        one: own[0].into(),
        other: own[1].into(),
        in_one: rest[0].into(),
        in_other: rest[1].into(),
        difference: difference.into(),
    };
    Ok((volumes, witness))
}

/// A point inside a solid, as deep below points of its faces as one is found.
fn inside(program: &Program, brep: &Brep) -> Option<DVec3> {
    /// Points that are tried, and how often the depth is halved.
    const MOST: usize = 256;
    const HALVINGS: i32 = 40;
    let bounds = brep.bounds()?;
    let size = bounds.size().max_element();
    let faces = brep.faces().flat_map(|face| {
        let points = face.points();
        // Between two points of a face there may be more room.
        let middles = points.windows(2).map(|pair| pair[0].midpoint(pair[1]));
        let middles: Vec<DVec3> = middles.collect();
        let all = middles.into_iter().chain(points);
        all.map(move |point| (point, face.normal(point)))
    });
    let places: Vec<(DVec3, DVec3)> = faces.take(MOST).collect();
    (1..HALVINGS).find_map(|halving| {
        let depth = size * 0.5_f64.powi(halving);
        let points = places.iter().map(|&(point, normal)| point - depth * normal);
        points.into_iter().find(|&point| program.contains(point))
    })
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = self.unit;
        if let Some(volumes) = &self.volumes {
            writeln!(f, "volume A      {} {unit}³", volumes.one)?;
            writeln!(f, "volume B      {} {unit}³", volumes.other)?;
            writeln!(f, "in A alone    {} {unit}³", volumes.in_one)?;
            writeln!(f, "in B alone    {} {unit}³", volumes.in_other)?;
            writeln!(f, "difference    {} {unit}³", volumes.difference)?;
        }
        if let Some(distance) = &self.distance {
            let lower = short(distance.lower, 4);
            match (distance.upper, distance.place) {
                (Some(upper), Some(place)) => {
                    let upper = at_most(upper, 4);
                    let place = place.map(|x| short(x, 6)).join(" ");
                    writeln!(f, "distance      {lower} to {upper} {unit}, about {place}")?;
                }
                (Some(upper), None) => writeln!(f, "distance      {upper} {unit}")?,
                (None, _) => writeln!(f, "distance      unknown")?,
            }
        }
        if let Some(witness) = &self.witness {
            let point = witness.point.map(|x| short(x, 9)).join(" ");
            let name = if witness.inside == "one" { "A" } else { "B" };
            writeln!(f, "witness       {point} is in {name} alone")?;
        }
        let verdict = match self.equal {
            Some(true) => "equal",
            Some(false) => "different",
            None => "open: the distance may be what was asked for, or more (--tolerance)",
        };
        writeln!(f, "{verdict}")
    }
}
