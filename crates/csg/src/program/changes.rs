//! Does the solid really change across these surfaces at this point?

use crate::elementary;
use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::cell::Cell;
use crate::numeric::tolerance::{SAME_ANGLE, TOUCHING};
use crate::surface::Surface;

/// Bit i of the k-th: bit k of i.
const VARIABLES: [u64; 6] = [
    0xaaaa_aaaa_aaaa_aaaa,
    0xcccc_cccc_cccc_cccc,
    0xf0f0_f0f0_f0f0_f0f0,
    0xff00_ff00_ff00_ff00,
    0xffff_0000_ffff_0000,
    0xffff_ffff_0000_0000,
];

/// How a point lies to one surface.
#[derive(Clone, Copy, Debug)]
enum Lies {
    /// On one of those asked about: its place among them.
    OnOwn(usize),
    /// On another one.
    On,
    Inside,
    Outside,
}

/// Scratch memory for asking.
#[derive(Debug, Default)]
pub(crate) struct Changes {
    lies: Vec<Lies>,
    signs: Vec<u64>,
    gates: Vec<u64>,
}

impl Changes {
    /// Whether the solid changes across each of the surfaces `own` (by their
    /// numbers in `surfaces`), all of which pass through `point`: the formula
    /// over all their sign combinations, the other surfaces as they are there,
    /// both ways where they are nearer than `tolerance`. Where more than six
    /// pass through the point its neighbourhood tells: a cone of directions.
    pub fn across(
        &mut self,
        surfaces: &[Surface],
        cell: &Cell,
        own: &[u32],
        point: DVec3,
        tolerance: f64,
    ) -> bool {
        self.lies.clear();
        let mut others = 0;
        for id in &cell.surfaces {
            let surface = &surfaces[*id as usize];
            let lies = if let Some(k) = own.iter().position(|own| own == id) {
                Lies::OnOwn(k)
            } else {
                let value = surface.value(point);
                if value.abs() <= tolerance * surface.gradient(point).length() {
                    others += 1;
                    Lies::On
                } else if value <= 0.0 {
                    Lies::Inside
                } else {
                    Lies::Outside
                }
            };
            self.lies.push(lies);
        }
        let free = own.len() + others;
        if free > VARIABLES.len() {
            return self.across_by_sectors(surfaces, cell, own, point);
        }
        let mut others = own.len()..;
        self.signs.clear();
        self.signs.extend(self.lies.iter().map(|lies| match *lies {
            Lies::OnOwn(k) => VARIABLES[k],
            Lies::On => others.next().map_or(0, |k| VARIABLES[k]),
            Lies::Inside => u64::MAX,
            Lies::Outside => 0,
        }));
        let table = self.evaluate(cell);
        // The low 2^free bits.
        let assignments = u64::MAX >> (64 - (1 << free));
        (0..own.len()).all(|k| {
            let toggled = table >> (1 << k);
            (table ^ toggled) & !VARIABLES[k] & assignments != 0
        })
    }

    /// The same where more surfaces pass through the point than sides can be
    /// tried. The lines in which the others cut a surface's tangent plane part
    /// it into sectors, and the formula tells whether the solid changes in any
    /// of them.
    fn across_by_sectors(
        &mut self,
        surfaces: &[Surface],
        cell: &Cell,
        own: &[u32],
        point: DVec3,
    ) -> bool {
        /// Two assignments each: inside the surface and outside.
        const MOST_SECTORS: usize = 32;
        const INSIDE: u64 = 0x5555_5555_5555_5555;
        // Of each surface through the point the unit normal.
        let normals: Vec<Option<DVec3>> = cell
            .surfaces
            .iter()
            .zip(&self.lies)
            .map(|(&id, lies)| {
                let normal = || surfaces[id as usize].gradient(point).normalize_or_zero();
                matches!(lies, Lies::OnOwn(_) | Lies::On).then(normal)
            })
            .collect();
        own.iter().all(|own| {
            let place = cell.surfaces.iter().position(|id| id == own);
            let normal = place.and_then(|place| normals[place]);
            let Some(normal) = normal.filter(|n| *n != DVec3::ZERO) else {
                return true;
            };
            let (u, v) = normal.any_orthonormal_pair();
            let mut angles: Vec<f64> = normals
                .iter()
                .flatten()
                .map(|other| normal.cross(*other))
                .filter(|line| line.length() > TOUCHING)
                .map(|line| elementary::atan2(line.dot(v), line.dot(u)).rem_euclid(PI))
                .flat_map(|angle| [angle, angle + PI])
                .collect();
            angles.sort_by(f64::total_cmp);
            angles.dedup_by(|a, b| (*a - *b).abs() < SAME_ANGLE);
            let next = angles.iter().skip(1).copied();
            let next = next.chain(angles.first().map(|first| first + TAU));
            let mut sectors: Vec<DVec3> = angles
                .iter()
                .zip(next)
                .map(|(from, to)| 0.5 * (from + to))
                .map(|angle| elementary::cos(angle) * u + elementary::sin(angle) * v)
                .collect();
            if sectors.is_empty() {
                sectors.push(u);
            }
            sectors.truncate(MOST_SECTORS);
            self.signs.clear();
            for (s, (normal, lies)) in normals.iter().zip(&self.lies).enumerate() {
                self.signs.push(match (normal, lies) {
                    _ if Some(s) == place => INSIDE,
                    (Some(other), _) => sectors.iter().enumerate().fold(0, |bits, (i, sector)| {
                        let inside = other.dot(*sector) <= 0.0;
                        bits | if inside { 3 << (2 * i) } else { 0 }
                    }),
                    (None, Lies::Inside) => u64::MAX,
                    (None, _) => 0,
                });
            }
            let result = self.evaluate(cell);
            let known = u64::MAX >> (64 - 2 * sectors.len());
            (result ^ result >> 1) & INSIDE & known != 0
        })
    }

    /// Whether the solid contains a point of the cell.
    pub fn contains(&mut self, surfaces: &[Surface], cell: &Cell, point: DVec3) -> bool {
        self.signs.clear();
        self.signs.extend(cell.surfaces.iter().map(|&id| {
            let inside = surfaces[id as usize].value(point) <= 0.0;
            if inside { u64::MAX } else { 0 }
        }));
        self.evaluate(cell) & 1 == 1
    }

    fn evaluate(&mut self, cell: &Cell) -> u64 {
        let signs = &self.signs;
        cell.formula
            .evaluate_words(&mut self.gates, |_, surface| signs[surface as usize])
    }
}
