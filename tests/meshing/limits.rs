//! What a mesh may cost: limits are kept, and said where they were reached.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use csg::{
    CancelToken, Demand, Error, Limit, LimitReached, Limits, Meshed, Mesher, Program, Solid,
};
use stereotomy::{csg, scenes};

use super::tolerance::sampled_deviation;
use crate::sweeps::one_in;

fn lower(solid: &Solid) -> Program {
    Program::lower(solid).expect("a valid solid")
}

/// A way of meshing something, by name.
struct Way {
    name: &'static str,
    program: Program,
    mesher: Mesher,
}

fn ways() -> Vec<Way> {
    // The triangles of some are inversely proportional to it.
    let coarser = one_in(4) as f64;
    let way = |name, solid, mesher| Way {
        name,
        program: lower(&solid),
        mesher,
    };
    vec![
        way("uniform", scenes::drilled(), Mesher::new().cells(60)),
        way(
            "uniform to a tolerance",
            scenes::sphere(),
            Mesher::new().cells(30).tolerance(1e-4),
        ),
        way(
            "adaptive",
            scenes::flange(),
            Mesher::new().smallest_feature(1e-3),
        ),
        way(
            "to a tolerance",
            scenes::flange(),
            Mesher::new().tolerance(1e-5 * coarser),
        ),
        way(
            "to an angle",
            scenes::flange(),
            Mesher::new().tolerance(1e-2).angle(0.02 * coarser.sqrt()),
        ),
        way(
            "polyhedral",
            scenes::menger(3),
            Mesher::new().tolerance(1e-3),
        ),
        way("draft", scenes::drilled(), Mesher::new().cells(60).draft()),
    ]
}

fn mesh(way: &Way) -> Meshed {
    way.mesher.mesh(&way.program).expect("a mesh")
}

fn limit_of(result: Result<Meshed, Error>) -> LimitReached {
    match result {
        Err(Error::LimitReached(reached)) => reached,
        other => panic!("{other:?}"),
    }
}

/// The limits of a third of what a mesh took, about, one by one.
fn thirds(meshed: &Meshed) -> [(Limits, Limit); 2] {
    let cells = meshed.report.cells_visited / 3;
    let triangles = meshed.mesh.triangles.len() as u64 / 3;
    [
        (Limits::new().cells(cells), Limit::Cells(cells)),
        (
            Limits::new().triangles(triangles),
            Limit::Triangles(triangles),
        ),
    ]
}

#[test]
fn limits_that_are_not_reached_change_nothing() {
    for way in ways() {
        let plain = mesh(&way);
        let (cells, triangles) = (plain.report.cells_visited, plain.mesh.triangles.len());
        let limits = Limits::new()
            .cells(cells)
            .triangles(triangles as u64)
            .memory(1 << 40);
        for limits in [limits, limits.partial()] {
            let limited = way.mesher.clone().limits(limits).mesh(&way.program);
            let limited = limited.unwrap_or_else(|e| panic!("{}: {e}", way.name));
            assert!(limited.mesh == plain.mesh, "{}", way.name);
            assert_eq!(limited.report.limits_reached, [], "{}", way.name);
        }
    }
}

#[test]
fn a_limit_is_an_error_that_says_which_and_what_to_do() {
    for way in ways() {
        for (limits, limit) in thirds(&mesh(&way)) {
            let result = way.mesher.clone().limits(limits).mesh(&way.program);
            let message = result.as_ref().expect_err(way.name).to_string();
            assert!(message.contains(&limit.to_string()), "{message}");
            assert!(message.contains("raise the limit"), "{message}");
            let reached = limit_of(result);
            assert_eq!((reached.limit, reached.kept), (limit, None), "{}", way.name);
        }
        // Nothing can be made of nothing.
        let limits = Limits::new().triangles(3);
        for limits in [limits, limits.partial()] {
            let result = way.mesher.clone().limits(limits).mesh(&way.program);
            assert_eq!(limit_of(result).limit, Limit::Triangles(3));
        }
    }
}

#[test]
fn what_fits_a_limit_is_closed_and_says_what_it_keeps() {
    for way in ways() {
        let plain = mesh(&way);
        for (limits, limit) in thirds(&plain) {
            let name = format!("{} within {limit}", way.name);
            let mesher = way.mesher.clone().limits(limits.partial());
            if limit == Limit::Cells(0) {
                assert_eq!(limit_of(mesher.mesh(&way.program)).limit, limit, "{name}");
                continue;
            }
            let Meshed { mesh, report, .. } = match mesher.mesh(&way.program) {
                Ok(meshed) => meshed,
                Err(error) => panic!("{name}: {error}"),
            };
            // A draft is closed; the others are manifold.
            assert!(report.check.is_closed(), "{name}: {}", report.check);
            assert!(
                report.check.is_manifold() || way.name == "draft",
                "{name}: {}",
                report.check
            );
            assert!(!report.limits_reached.is_empty(), "{name}");
            for reached in &report.limits_reached {
                assert_eq!(reached.limit, limit, "{name}");
                let kept = reached.kept.expect("a size");
                match reached.demand {
                    Demand::Cells(asked) => {
                        assert!(kept > asked, "{name}: {reached}");
                        assert_eq!(kept, report.cell_size, "{name}");
                    }
                    Demand::Tolerance(asked) => {
                        assert!(kept > asked, "{name}: {reached}");
                        let deviation = report.deviation.expect("a bound");
                        assert!(deviation <= kept, "{name}");
                        // What is farther off than was asked for is named.
                        let named = report.fallbacks.iter().any(|f| f.count > 0);
                        assert_eq!(named, deviation > asked, "{name}");
                    }
                    _ => assert_eq!(kept, report.cell_size, "{name}"),
                }
            }
            match limit {
                Limit::Cells(most) => {
                    assert!((1..=most).contains(&report.cells_visited), "{name}");
                }
                Limit::Triangles(most) => {
                    let count = mesh.triangles.len() as u64;
                    assert!((most / 8..=most).contains(&count), "{name}: {count}");
                }
                _ => unreachable!(),
            }
        }
    }
}

/// The best within the limit: no tolerance much smaller would have fit.
#[test]
fn a_limit_of_triangles_is_made_use_of() {
    for (solid, most) in [(scenes::sphere(), 5_000), (scenes::drilled(), 20_000)] {
        let program = lower(&solid);
        let limits = Limits::new().triangles(most).partial();
        let mesher = Mesher::new().tolerance(1e-6).limits(limits);
        let meshed = mesher.mesh(&program).expect("a mesh");
        let count = meshed.mesh.triangles.len() as u64;
        assert!((most * 3 / 4..=most).contains(&count), "{count} of {most}");
        let bound = meshed.report.deviation.expect("a bound");
        assert!(sampled_deviation(&program, &meshed) <= 1.02 * bound);
    }
}

#[test]
fn counts_are_the_same_on_any_number_of_threads() {
    let pools = [1, 8].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("threads")
    });
    for way in ways() {
        let plain = mesh(&way);
        let memory = Limits::new().memory(300 * plain.mesh.triangles.len() as u64 / 4);
        let limits = thirds(&plain).map(|(limits, _)| limits);
        for limits in limits.into_iter().chain([memory]) {
            for limits in [limits, limits.partial()] {
                let mesher = way.mesher.clone().limits(limits);
                let results = [0, 1].map(|i| pools[i].install(|| mesher.mesh(&way.program)));
                match results {
                    [Ok(one), Ok(eight)] => {
                        assert!(one.mesh == eight.mesh, "{} {limits:?}", way.name);
                        assert_eq!(one.report.limits_reached, eight.report.limits_reached);
                    }
                    [one, eight] => assert_eq!(one, eight, "{} {limits:?}", way.name),
                }
            }
        }
    }
}

#[test]
fn time_ends_the_work() {
    let long = [
        // Seconds or minutes each, if they were let.
        (scenes::sphere(), Mesher::new().tolerance(1e-7)),
        (
            Solid::ellipsoid([1.0, 0.9, 0.8]),
            Mesher::new().tolerance(1e-9),
        ),
        (scenes::drilled(), Mesher::new().cells(30_000)),
        (scenes::menger(6), Mesher::new()),
        (scenes::drilled(), Mesher::new().cells(4_000).draft()),
    ];
    for (solid, mesher) in long {
        let program = lower(&solid);
        let time = Duration::from_millis(100);
        let mesher = mesher.limits(Limits::new().time(time));
        let start = Instant::now();
        assert_eq!(limit_of(mesher.mesh(&program)).limit, Limit::Time(time));
        // Far more than it takes, on a machine with other things to do.
        assert!(start.elapsed() < Duration::from_secs(10));
    }
}

#[test]
fn the_finest_mesh_found_in_time_is_kept() {
    for (solid, mesher, genus) in [
        (scenes::drilled(), Mesher::new().tolerance(1e-9), 5),
        (scenes::drilled(), Mesher::new().cells(60_000), 5),
    ] {
        let program = lower(&solid);
        let time = Duration::from_secs(3);
        let mesher = mesher.limits(Limits::new().time(time).partial());
        let meshed = mesher.mesh(&program).expect("a mesh");
        assert!(meshed.report.check.is_manifold());
        assert_eq!(meshed.report.check.genus(), Some(genus));
        let [reached] = meshed.report.limits_reached[..] else {
            panic!("{:?}", meshed.report.limits_reached);
        };
        assert_eq!(reached.limit, Limit::Time(time));
        let kept = reached.kept.expect("a size");
        match reached.demand {
            Demand::Tolerance(asked) => {
                assert!(kept > asked && meshed.report.deviation <= Some(kept));
            }
            Demand::Cells(asked) => {
                assert!(kept > asked && meshed.report.cell_size == kept);
            }
            _ => panic!("{reached}"),
        }
    }
    // With time enough the result is that without a limit.
    let program = lower(&scenes::flange());
    let mesher = Mesher::new().tolerance(1e-3);
    let limits = Limits::new().time(Duration::from_secs(1000)).partial();
    let limited = mesher
        .clone()
        .limits(limits)
        .mesh(&program)
        .expect("a mesh");
    let plain = mesher.mesh(&program).expect("a mesh");
    assert!(limited.mesh == plain.mesh);
    assert_eq!(limited.report.limits_reached, []);
}

#[test]
fn progress_is_told_and_cancelling_heard_within_the_exact_boundary() {
    let program = lower(&scenes::menger(3));
    let told: Arc<Mutex<Vec<f64>>> = Arc::default();
    let list = Arc::clone(&told);
    let mesher = Mesher::new().progress(move |share| list.lock().expect("a list").push(share));
    mesher.mesh(&program).expect("a mesh");
    let mut shares = std::mem::take(&mut *told.lock().expect("a list"));
    shares.sort_by(f64::total_cmp);
    assert_eq!(shares.last(), Some(&1.0));
    let gaps = shares.windows(2).map(|pair| pair[1] - pair[0]);
    let widest = gaps.fold(shares[0], f64::max);
    assert!(widest < 0.15, "{widest} in {shares:?}");
    for share in [0.05, 0.3, 0.6, 0.95] {
        let token = CancelToken::new();
        let (seen, cancel) = (Arc::clone(&told), token.clone());
        let mesher = Mesher::new().cancel_token(token).progress(move |at| {
            seen.lock().expect("a list").push(at);
            if at >= share {
                cancel.cancel();
            }
        });
        assert_eq!(mesher.mesh(&program), Err(Error::Cancelled), "{share}");
        let seen = std::mem::take(&mut *told.lock().expect("a list"));
        let last = seen.into_iter().fold(0.0, f64::max);
        assert!(last < 1.0 && last < share + 0.2, "{share}: {last}");
    }
}

/// Half of the work of a mesh to a tolerance comes after its topology is there.
#[test]
fn progress_leaves_room_for_refining() {
    let program = lower(&scenes::drilled());
    let told: Arc<Mutex<Vec<f64>>> = Arc::default();
    let list = Arc::clone(&told);
    let mesher = Mesher::new()
        .tolerance(1e-4)
        .progress(move |share| list.lock().expect("a list").push(share));
    mesher.mesh(&program).expect("a mesh");
    let mut shares = std::mem::take(&mut *told.lock().expect("a list"));
    shares.sort_by(f64::total_cmp);
    assert_eq!(shares.last(), Some(&1.0));
    // The boundary, the refined mesh, and what is without crossings, each by itself.
    for range in [0.05..=0.1, 0.45..=0.5, 0.8..=0.87] {
        assert!(
            shares.iter().any(|share| range.contains(share)),
            "{shares:?}"
        );
    }
    // It does not stand still while a single part is refined.
    let within = shares.iter().filter(|share| (0.12..0.48).contains(*share));
    assert!(within.count() >= 3, "{shares:?}");
    // Nor while the mesh is checked.
    let checked = shares.iter().filter(|&&share| share > 0.87);
    assert!(checked.count() >= 4, "{shares:?}");
}
